#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <glm/glm.hpp>

namespace vps {

// Signs by empty balls. No surface is in the ball around x whose radius is the distance d(x) to the nearest surface,
// and the winding number of a closed surface changes only at the surface. So x and y lie on one side where their balls
// meet:
//
//   d(x) + d(y) > |x - y|.
//
// kSettledMargin, in voxels: by so much the balls must overlap, for distances are rounded (words: 1/512 voxel,
// RowTriangle: 1e-3). As d(x) >= d(y) - |x - y|, both points are then farther than half the margin from the surface,
// where no rounding turns the sign of a winding number: a settled sign is the one that would have been found.
constexpr double kSettledMargin = 0.02;

// Places with known signs, for finding those of others. The latest are kept. Voxel units.
class SettledSigns {
 public:
  // `is_closed`: whether the surface is (TriangleField::signs_spread). Else every sign is asked.
  explicit SettledSigns(bool is_closed) : is_closed_(is_closed) {}

  void Add(const glm::dvec3& p, double radius, double sign) { balls_[count_++ % kMost] = {p, radius, sign}; }
  // The sign at p, whose distance from the surface is `radius`; ask() gives it where no known place does.
  template <class Ask>
  double SignAt(const glm::dvec3& p, double radius, Ask&& ask) {
    if (!is_closed_) return ask();
    double sign = Find(p, radius);
    if (sign == 0.0) sign = ask();
    Add(p, radius, sign);
    return sign;
  }

 private:
  static constexpr std::size_t kMost = 64;  // 27 cells' centres and the 24 places of FitCrease
  struct Ball {
    glm::dvec3 centre;
    double radius, sign;
  };

  // 0: no known place settles it.
  [[nodiscard]] double Find(const glm::dvec3& p, double radius) const {
    for (std::size_t k = count_; k > 0 && count_ - k < kMost; --k) {
      const Ball& ball = balls_[(k - 1) % kMost];
      const glm::dvec3 r = p - ball.centre;
      const double reach = ball.radius + radius - kSettledMargin;
      if (reach > 0.0 && glm::dot(r, r) < reach * reach) return ball.sign;
    }
    return 0.0;
  }

  bool is_closed_;
  std::size_t count_ = 0;
  std::array<Ball, kMost> balls_;
};

// The same for a brick's samples, 0, 1, ..., 7 in each direction, x fastest: samples of one side hang together through
// their neighbours' balls, so that few are asked.
struct SampleSigns {
  std::array<float, 512> radius;  // distance from the surface; negative: not known
  std::bitset<512> is_wanted;
  std::array<float, 512> sign;  // of the wanted ones, once settled

  // ask(k) gives the sign at sample k.
  template <class Ask>
  void Settle(bool is_closed, Ask&& ask) {
    sign.fill(0.0f);
    for (std::size_t k = 0; k < radius.size(); ++k) {
      if (!is_wanted[k] || sign[k] != 0.0f) continue;
      sign[k] = ask(k);
      if (is_closed) Spread(k);
    }
  }

 private:
  // Gives the sign of a sample to all that hang together with it.
  void Spread(std::size_t first);
};

}  // namespace vps
