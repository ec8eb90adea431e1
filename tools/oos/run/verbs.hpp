#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb RunVerb();
Verb LatencyVerb();

}  // namespace oos
