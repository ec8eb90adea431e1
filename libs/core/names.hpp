#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace core {

// The candidate with the smallest edit distance to `word`, if it may be a typing error (at most a third of the word, or
// two characters, differ); else empty.
std::string NearestName(std::string_view word, const std::vector<std::string>& candidates);

// "'a', 'b' and 'c'"; "none" for an empty list. For the remedy of an unknown name.
std::string ListNames(const std::vector<std::string>& names);

// Remedy for an unknown name: the nearest one, and the list of known names; of a long list, the 20 nearest.
std::string SuggestName(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace core
