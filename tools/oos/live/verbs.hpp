#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb TopicVerb();
Verb TopVerb();
Verb ViewVerb();
Verb SetVerb();
Verb FetchVerb();

}  // namespace oos
