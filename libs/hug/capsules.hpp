#pragma once

#include <array>
#include <glm/glm.hpp>

#include "hug/arm_dynamics.hpp"

namespace hug {

// A round bar: all points within `radius_m` of a segment.
struct Capsule {
  glm::dvec3 a{0.0}, b{0.0};
  double radius_m = 0.0;
};

struct ClosestPoints {
  glm::dvec3 on_first{0.0}, on_second{0.0};  // on the segments
  double distance_m = 0.0;                   // between the surfaces; negative: they overlap
};
ClosestPoints Closest(const Capsule& first, const Capsule& second);

// An arm as four bars; the last one reaches to the hand.
struct ArmBar {
  std::size_t link;  // that the bar is fixed to
  Capsule capsule;
};
using ArmBars = std::array<ArmBar, 4>;
// Radius of the bar that link i is part of.
double RadiusOf(std::size_t link);
ArmBars BarsOf(const ArmDynamics& arm);

}  // namespace hug
