#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb StarsVerb();
Verb AtmosphereVerb();

}  // namespace oos
