#pragma once

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <vector>

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
  [[nodiscard]] double HeightBetween(double x0, double x1) const {
    return height_m() * (x0 <= foot_ && foot_ <= x1 ? 1.0 : std::max(Share(x0), Share(x1)));
  }
  // The polygon between two places along the longest side: three to five corners.
  [[nodiscard]] std::vector<glm::dvec3> Slice(double x0, double x1) const {
    std::vector<glm::dvec3> corners = {Bottom(x0), Bottom(x1)};
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

}  // namespace vps
