#include "vps/mesh/part_size.hpp"

#include <algorithm>
#include <cstdio>

namespace vps {
namespace {

std::string Meters(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", length_m);
  return text;
}

}  // namespace

double LongestSide_m(const Box& box) {
  const glm::dvec3 size = box.upper - box.lower;
  return std::max({size.x, size.y, size.z});
}

core::Result<void> CheckPartSize(const std::string& name, const Box& box) {
  const double size_m = LongestSide_m(box);
  if (size_m >= kSmallestPart_m && size_m <= kLargestPart_m) return {};
  const bool is_large = size_m > kLargestPart_m;
  return core::Fail(core::ErrorCode::kInvalidInput,
                    name + ": the longest side of the mesh is " + Meters(size_m) + ", a part has " +
                        Meters(kSmallestPart_m) + " to " + Meters(kLargestPart_m) +
                        ": wrong unit? Export it in metres (`oos query` and `oos inspect` also read it with --scale " +
                        (is_large ? "0.001" : "1000") + ")");
}

core::Result<void> CheckSameUnit(const std::string& name_A, const Box& A, const std::string& name_B, const Box& B) {
  const double size_A = LongestSide_m(A);
  const double size_B = LongestSide_m(B);
  if (std::max(size_A, size_B) <= kLargestSizeRatio * std::min(size_A, size_B)) return {};
  const bool is_A_large = size_A > size_B;
  return core::Fail(core::ErrorCode::kInvalidInput,
                    (is_A_large ? name_A : name_B) + ": the longest side of the mesh is " +
                        Meters(std::max(size_A, size_B)) + ", that of " + (is_A_large ? name_B : name_A) + " is " +
                        Meters(std::min(size_A, size_B)) +
                        ": is one of them in millimetres? Export both in metres; --scale 0.001 reads both as "
                        "millimetres, --scale 1 accepts these sizes");
}

std::string Millimetres(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * length_m);
  return text;
}

}  // namespace vps
