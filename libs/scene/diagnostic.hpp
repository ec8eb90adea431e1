#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/scenario.hpp"

namespace scene {

// One thing that is wrong in a file, for the person who edits it.
struct Diagnostic {
  Location where;
  std::string what;  // the thing that is wrong, e.g. "object 'block': mass_kg is -1"
  std::string why;   // the rule that it breaks
  std::string fix;   // what to write instead
};

// "file:line: what: why. Fix: fix."
std::string Format(const Diagnostic& diagnostic);

// The candidate with the smallest edit distance to `word`, if it is near enough to be a slip; else empty.
std::string NearestName(std::string_view word, const std::vector<std::string>& candidates);

// "'a', 'b' and 'c'"; "none" for an empty list. For the remedy of an unknown name.
std::string ListNames(const std::vector<std::string>& names);

// Remedy for an unknown name: the nearest one, or the list of those that exist.
std::string SuggestName(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace scene
