#pragma once

#include <string>
#include <vector>

#include "tools/oos/verb/verb.hpp"

namespace oos {

// In the order of `oos --help`.
std::vector<Verb> AllVerbs();

// Runs `oos` with these words, without the program's name. Returns the exit status.
int RunCommandLine(const std::vector<std::string>& words);

}  // namespace oos
