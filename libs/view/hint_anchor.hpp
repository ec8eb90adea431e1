#pragma once

#include <string>
#include <vector>

namespace view {

// The object that an instruction is about: all words of its name (between underscores) stand in the instruction. Of
// several, the one whose name has most words, then the one that is named first. -1: none, so nothing is pointed at.
int FindNamedObject(const std::string& instruction, const std::vector<std::string>& objects);

}  // namespace view
