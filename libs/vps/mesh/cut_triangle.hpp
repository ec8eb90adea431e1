#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "core/fixed_vector.hpp"

namespace vps {

// A long thin triangle on its longest side: (0, 0), (length, 0), (foot, height), metres.
class Sliver {
 public:
  explicit Sliver(const std::array<glm::dvec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
    const std::size_t k = static_cast<std::size_t>(std::max_element(sides, sides + 3) - sides);
    from_ = corners[k];
    apex_ = corners[(k + 2) % 3];
    length_ = sides[k];
    along_ = (corners[(k + 1) % 3] - from_) / length_;
    foot_ = std::clamp(glm::dot(apex_ - from_, along_), 0.0, length_);
    upwards_ = apex_ - (from_ + foot_ * along_);
  }
  // Halving the longest side keeps the shape: a triangle of length l and height h gives l / h times as many parts as
  // its area needs. A thin one is cut across first. The limit of 8 is not derived.
  [[nodiscard]] bool is_thin() const { return length_ > 8.0 * height_m(); }
  [[nodiscard]] double length_m() const { return length_; }
  [[nodiscard]] double height_m() const { return glm::length(upwards_); }
  // The polygon between two places along the longest side: three to five corners.
  [[nodiscard]] core::FixedVector<glm::dvec3, 5> Slice(double x0, double x1) const {
    core::FixedVector<glm::dvec3, 5> corners;
    corners.push_back(Bottom(x0));
    corners.push_back(Bottom(x1));
    if (x1 < length_) corners.push_back(Bottom(x1) + Share(x1) * upwards_);
    if (x0 < foot_ && foot_ < x1) corners.push_back(apex_);
    if (x0 > 0.0) corners.push_back(Bottom(x0) + Share(x0) * upwards_);
    return corners;
  }

 private:
  [[nodiscard]] glm::dvec3 Bottom(double x) const { return from_ + x * along_; }
  [[nodiscard]] double Share(double x) const { return x < foot_ ? x / foot_ : (length_ - x) / (length_ - foot_); }

  glm::dvec3 from_, apex_, along_, upwards_;
  double length_ = 0.0, foot_ = 0.0;
};

// Halves a triangle across its longest side, and each half, until that is at most `longest_m`. Both triangles at a side
// halve it at the same place. Calls take(a, b, c) for each part; false ends it, and is returned.
template <class Take>
bool HalveTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double longest_m, const Take& take) {
  const glm::dvec3 corners[3] = {a, b, c};
  const auto squared = [&](int k) {
    const glm::dvec3 side = corners[(k + 1) % 3] - corners[k];
    return glm::dot(side, side);
  };
  int k = squared(1) > squared(0) ? 1 : 0;
  if (squared(2) > squared(k)) k = 2;
  if (squared(k) <= longest_m * longest_m) return take(a, b, c);
  const glm::dvec3& from = corners[k];
  const glm::dvec3& to = corners[(k + 1) % 3];
  const glm::dvec3& apex = corners[(k + 2) % 3];
  const glm::dvec3 middle = 0.5 * (from + to);
  return HalveTriangle(from, middle, apex, longest_m, take) && HalveTriangle(middle, to, apex, longest_m, take);
}

// The same for a triangle of any shape: a thin one is cut across first.
template <class Take>
bool CutTriangle(const std::array<glm::dvec3, 3>& corners, double longest_m, const Take& take) {
  const Sliver sliver(corners);
  if (!sliver.is_thin()) return HalveTriangle(corners[0], corners[1], corners[2], longest_m, take);
  constexpr double kSlice = 0.95;  // so that the diagonals of slices are not too long
  const auto num_slices = static_cast<std::uint32_t>(std::ceil(sliver.length_m() / (kSlice * longest_m)));
  const double step_m = sliver.length_m() / num_slices;
  for (std::uint32_t i = 0; i < num_slices; ++i) {
    const double end_m = i + 1 < num_slices ? (i + 1) * step_m : sliver.length_m();
    const auto slice = sliver.Slice(i * step_m, end_m);
    for (std::size_t k = 2; k < slice.size(); ++k) {
      if (!HalveTriangle(slice[0], slice[k - 1], slice[k], longest_m, take)) return false;
    }
  }
  return true;
}

}  // namespace vps
