#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

// Options of a picture without a session: --shot and what goes with it.
const std::vector<Option>& ShotOptions();

bool IsShotWanted(const Arguments& arguments);

// Makes the pictures that the options name, of the scenario or recording that is the first positional argument.
// Replaces this process; returns an exit status only when that fails.
int MakeShot(const Arguments& arguments);

}  // namespace oos
