#include "core/names.hpp"

#include <algorithm>
#include <numeric>

namespace core {
namespace {

constexpr std::size_t kMostListed = 20;

// Levenshtein distance: the least number of inserted, deleted and replaced characters; one row of the table at a time.
std::size_t ComputeEditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

std::string NearestName(std::string_view word, const std::vector<std::string>& candidates) {
  // At most a third of the word, or two characters, may differ: "stifness" finds "stiffness", "lamp" does not find
  // "plate". Chosen on such pairs (names_test): a wider limit suggests unrelated names.
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  std::string best;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = ComputeEditDistance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string ListNames(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += "'" + names[i] + "'";
  }
  return text;
}

std::string SuggestName(std::string_view word, const std::vector<std::string>& candidates) {
  std::string known = ListNames(candidates);
  if (candidates.size() > kMostListed) {
    std::vector<std::pair<std::size_t, std::string>> by_distance;
    for (const std::string& candidate : candidates) {
      by_distance.emplace_back(ComputeEditDistance(word, candidate), candidate);
    }
    std::sort(by_distance.begin(), by_distance.end());
    known.clear();
    for (std::size_t i = 0; i < kMostListed; ++i) known += "'" + by_distance[i].second + "', ";
    known += "and " + std::to_string(candidates.size() - kMostListed) + " more";
  }
  const std::string nearest = NearestName(word, candidates);
  if (!nearest.empty()) return "did you mean '" + nearest + "'? Known: " + known;
  return "use one of the known names: " + known;
}

}  // namespace core
