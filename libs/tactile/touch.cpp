#include "tactile/touch.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace tactile {
namespace {

// A sum of forces that is shorter against their magnitudes is the rounding of forces from all sides.
constexpr double kLeastShare = 1e-6;

}  // namespace

void TouchSum::Add(const core::ContactSet& contacts, const core::Pose& X_WS, const core::Pose& X_WG, bool is_sampled) {
  for (const core::ContactPlane& plane : contacts.planes) {
    const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
    const double gap_m = glm::dot(n_W, X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G));
    if (!(gap_m < 0.0)) continue;
    depth_m_ = std::max(depth_m_, -gap_m);
    const double press_N = -gap_m * static_cast<double>(plane.stiffness_N_per_m);
    force_N_ += press_N;
    pressed_W_N_ += (is_sampled ? -press_N : press_N) * n_W;  // n points from G to S
  }
}

Touch TouchSum::touch() const {
  const double length_N = glm::length(pressed_W_N_);
  const bool has_direction = length_N > kLeastShare * force_N_;
  return {depth_m_, force_N_, has_direction ? pressed_W_N_ / length_N : glm::dvec3(0.0)};
}

void ShareRound(const glm::dvec3& towards_B, double strength, std::span<float> levels) {
  if (levels.empty()) return;
  const auto count = static_cast<double>(levels.size());
  const double sideways = std::min(1.0, std::hypot(towards_B.x, towards_B.y));
  std::fill(levels.begin(), levels.end(), static_cast<float>((1.0 - sideways) * strength / count));
  double turn = std::atan2(towards_B.y, towards_B.x) / glm::two_pi<double>();
  turn -= std::floor(turn);
  const double place = turn * count;
  const double after = place - std::floor(place);
  const auto first = static_cast<std::size_t>(place) % levels.size();
  levels[first] += static_cast<float>(sideways * strength * (1.0 - after));
  levels[(first + 1) % levels.size()] += static_cast<float>(sideways * strength * after);
}

}  // namespace tactile
