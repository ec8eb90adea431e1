#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cli {

// Which values an option takes. Checked while the command line is parsed, and stated in the help.
struct Range {
  enum class Kind { kAny, kNumber, kCount, kWord };
  Kind kind = Kind::kAny;
  double least = 0.0, most = 0.0;                 // of a number
  std::uint64_t least_count = 0, most_count = 0;  // of a whole number
  std::string_view words;                         // "try|off|enforce"
};

constexpr Range Number(double least, double most) {
  return {Range::Kind::kNumber, least, most, 0, 0, {}};
}
constexpr Range Count(std::uint64_t least, std::uint64_t most) {
  return {Range::Kind::kCount, 0.0, 0.0, least, most, {}};
}
constexpr Range OneOf(std::string_view words) {
  return {Range::Kind::kWord, 0.0, 0.0, 0, 0, words};
}

// "a number from 0 to 3600", "a whole number from 1 to 64", "try, off or enforce"; empty for any text.
std::string Describe(const Range& range);

bool Contains(const Range& range, const std::string& value);

}  // namespace cli
