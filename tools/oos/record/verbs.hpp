#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

Verb RecordVerb();
Verb InfoVerb();
Verb CatVerb();
Verb RecoverVerb();
Verb MergeVerb();
Verb DiffVerb();
Verb ExportVerb();

}  // namespace oos
