#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb CookVerb();
Verb InspectVerb();
Verb QueryVerb();

}  // namespace oos
