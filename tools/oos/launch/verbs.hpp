#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb LaunchVerb();
Verb StatusVerb();
Verb AttachVerb();
Verb StopVerb();
Verb RegistryVerb();
Verb ClockVerb();

}  // namespace oos
