#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb DeviceVerb();

}  // namespace oos
