#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb RunVerb();
Verb LatencyVerb();
Verb ReportVerb();

}  // namespace oos
