#pragma once

#include <glm/glm.hpp>
#include <span>

#include "core/messages/haptic.hpp"
#include "core/pose.hpp"

namespace tactile {

// What a body touches, of all its contacts together.
struct Touch {
  double depth_m = 0.0;       // of the deepest
  double force_N = 0.0;       // sum of their magnitudes
  glm::dvec3 towards_W{0.0};  // unit vector to what presses; zero: nothing does, or from all sides
};

// Adds up the contacts of one body, from the planes as they are on the bus, with the poses of the moment.
class TouchSum {
 public:
  // Of a set that has the body as S (`is_sampled`) or as G.
  void Add(const core::ContactSet& contacts, const core::Pose& X_WS, const core::Pose& X_WG, bool is_sampled);
  [[nodiscard]] Touch touch() const;

 private:
  double depth_m_ = 0.0;
  double force_N_ = 0.0;
  glm::dvec3 pressed_W_N_{0.0};
};

// Strengths of motors that sit evenly round a limb, the first at x of B, the next towards y; z is along the limb. What
// touches from the side is shared linearly by the two motors next to it, so the place that is felt moves between them;
// what touches along the limb has no side, and all motors share it. The sum is `strength` whatever the direction.
void ShareRound(const glm::dvec3& towards_B, double strength, std::span<float> levels);

}  // namespace tactile
