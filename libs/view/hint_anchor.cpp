#include "view/hint_anchor.hpp"

#include <algorithm>
#include <cctype>

namespace view {
namespace {

// Lower-case words of letters and digits.
std::vector<std::string> WordsOf(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : text) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) != 0) {
      words.back() += static_cast<char>(std::tolower(letter));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

}  // namespace

int FindNamedObject(const std::string& instruction, const std::vector<std::string>& objects) {
  const std::vector<std::string> said = WordsOf(instruction);
  int best = -1;
  std::size_t most_words = 0, first_place = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::vector<std::string> name = WordsOf(objects[i]);
    std::size_t place = said.size();  // of the first of its words
    const bool is_named = !name.empty() && std::all_of(name.begin(), name.end(), [&](const std::string& word) {
      const auto at = static_cast<std::size_t>(std::find(said.begin(), said.end(), word) - said.begin());
      place = std::min(place, at);
      return at < said.size();
    });
    if (!is_named || name.size() < most_words || (name.size() == most_words && place >= first_place)) continue;
    best = static_cast<int>(i);
    most_words = name.size();
    first_place = place;
  }
  return best;
}

}  // namespace view
