#include "vps/mesh/check_text.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

namespace vps {
namespace {

std::string_view NextWord(std::string_view* line) {
  const std::size_t begin = line->find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return *line = {};
  const std::size_t end = std::min(line->find_first_of(" \t\r", begin), line->size());
  const std::string_view word = line->substr(begin, end - begin);
  line->remove_prefix(end);
  return word;
}

bool IsFinite(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
}

bool IsNonFinite(std::string_view word) {
  if (!word.empty() && (word.front() == '-' || word.front() == '+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && !std::isfinite(value);
}

// "v x y z" of OBJ and "vertex x y z" of STL must hold three numbers; OFF and PLY have bare numbers in their lines.
bool IsValidLine(std::string_view line) {
  const std::string_view first = NextWord(&line);
  if (first == "v" || first == "vertex") {
    for (int k = 0; k < 3; ++k) {
      if (!IsFinite(NextWord(&line))) return false;
    }
    return true;
  }
  if (IsNonFinite(first)) return false;
  if (!IsFinite(first)) return true;  // a keyword, a comment
  for (std::string_view word = NextWord(&line); !word.empty(); word = NextWord(&line)) {
    if (IsNonFinite(word)) return false;
  }
  return true;
}

}  // namespace

core::Result<void> CheckTextNumbers(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (line.find('\0') != std::string::npos || line.find("format binary") == 0) return {};
    if (IsValidLine(line)) continue;
    return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ":" + std::to_string(number) +
                                                          ": a corner is not a finite number ('" + line.substr(0, 60) +
                                                          "'); export the mesh again");
  }
  return {};
}

}  // namespace vps
