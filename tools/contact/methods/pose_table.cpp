#include "tools/contact/methods/pose_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace contact {
namespace {

std::string_view Trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> SplitAtCommas(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(Trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

bool ParseNumber(std::string_view text, double* value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

core::Result<std::vector<core::Pose>> ParsePoseTable(std::string_view text, std::string_view name) {
  std::vector<core::Pose> poses;
  bool may_be_heading = true;
  int number = 0;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);  // byte order mark
  const auto fail = [&](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + ":" + std::to_string(number) + ": " + what);
  };
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = Trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string_view> fields = SplitAtCommas(line);
    std::array<double, 7> v{};
    const bool is_heading = std::none_of(fields.begin(), fields.end(), [](std::string_view field) {
      double value = 0.0;
      return ParseNumber(field, &value);
    });
    if (std::exchange(may_be_heading, false) && is_heading) continue;
    if (fields.size() != v.size()) {
      return fail("a pose is px,py,pz,qw,qx,qy,qz: 7 numbers, not " + std::to_string(fields.size()));
    }
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (!ParseNumber(fields[i], &v[i]) || !std::isfinite(v[i])) {
        return fail("field " + std::to_string(i + 1) + " is not a finite number: '" + std::string(fields[i]) + "'");
      }
    }
    const glm::dquat q(v[3], v[4], v[5], v[6]);
    const double length = glm::length(q);
    if (std::abs(length - 1.0) > 1e-3) {
      char digits[32];
      std::snprintf(digits, sizeof(digits), "%.6g", length);
      return fail("the quaternion qw,qx,qy,qz has length " + std::string(digits) + ", not 1");
    }
    poses.push_back({q / length, {v[0], v[1], v[2]}});
  }
  if (poses.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + ": holds no pose (px,py,pz,qw,qx,qy,qz)");
  }
  return poses;
}

core::Result<std::vector<core::Pose>> ReadPoseTable(const std::filesystem::path& file) {
  std::error_code error;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file, error)) {
    return core::Fail(core::ErrorCode::kNotFound, file.string() + ": cannot be read");
  }
  std::stringstream text;
  text << stream.rdbuf();
  return ParsePoseTable(text.str(), file.string());
}

}  // namespace contact
