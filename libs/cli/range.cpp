#include "cli/range.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "cli/read_number.hpp"

namespace cli {
namespace {

std::vector<std::string> WordsOf(std::string_view words) {
  std::vector<std::string> all;
  for (std::size_t begin = 0; begin <= words.size();) {
    const std::size_t end = std::min(words.find('|', begin), words.size());
    all.emplace_back(words.substr(begin, end - begin));
    begin = end + 1;
  }
  return all;
}

std::string Text(double number) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, number);
  return {text, error == std::errc() ? end : text};
}

}  // namespace

std::string Describe(const Range& range) {
  switch (range.kind) {
    case Range::Kind::kAny:
      return {};
    case Range::Kind::kNumber:
      return "a number from " + Text(range.least) + " to " + Text(range.most);
    case Range::Kind::kCount:
      if (range.most_count == std::numeric_limits<std::uint64_t>::max()) {
        return "a whole number, " + std::to_string(range.least_count) + " or more";
      }
      return "a whole number from " + std::to_string(range.least_count) + " to " + std::to_string(range.most_count);
    case Range::Kind::kWord:
      break;
  }
  const std::vector<std::string> words = WordsOf(range.words);
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  }
  return text;
}

bool Contains(const Range& range, const std::string& value) {
  if (range.kind == Range::Kind::kAny) return true;
  if (range.kind == Range::Kind::kNumber) {
    const auto number = ReadNumber(value);
    return number && *number >= range.least && *number <= range.most;
  }
  if (range.kind == Range::Kind::kCount) {
    const auto count = ReadCount(value);
    return count && *count >= range.least_count && *count <= range.most_count;
  }
  const std::vector<std::string> words = WordsOf(range.words);
  return std::find(words.begin(), words.end(), value) != words.end();
}

}  // namespace cli
