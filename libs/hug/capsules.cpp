#include "hug/capsules.hpp"

#include <algorithm>

namespace hug {
namespace {

// Radii of the bars: assumed, from the width of the arm's tubes, with a centimetre to spare.
constexpr double kUpperArm_m = 0.08, kForearm_m = 0.07, kHand_m = 0.05;

}  // namespace

// Nearest points of two segments p1 + s d1, p2 + t d2, with s and t in [0, 1] [Ericson, Real-Time Collision Detection,
// 2005, section 5.1.9]: the minimum of a quadratic in s and t, clamped in t, then in s.
ClosestPoints Closest(const Capsule& first, const Capsule& second) {
  const glm::dvec3 d1 = first.b - first.a, d2 = second.b - second.a, r = first.a - second.a;
  const double a = glm::dot(d1, d1), e = glm::dot(d2, d2), f = glm::dot(d2, r), c = glm::dot(d1, r);
  constexpr double kPoint_m2 = 1e-18;
  double s = 0.0, t = 0.0;
  if (a <= kPoint_m2 && e > kPoint_m2) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else if (a > kPoint_m2 && e <= kPoint_m2) {
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (a > kPoint_m2) {
    const double b = glm::dot(d1, d2);
    const double denominator = a * e - b * b;  // 0: parallel, any s will do
    if (denominator > 1e-12 * a * e) s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
    t = (b * s + f) / e;
    if (t < 0.0 || t > 1.0) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  }
  ClosestPoints closest;
  closest.on_first = first.a + s * d1;
  closest.on_second = second.a + t * d2;
  closest.distance_m = glm::distance(closest.on_first, closest.on_second) - first.radius_m - second.radius_m;
  return closest;
}

double RadiusOf(std::size_t link) {
  return link < 3 ? kUpperArm_m : link < 5 ? kForearm_m : kHand_m;
}

ArmBars BarsOf(const ArmDynamics& arm) {
  const glm::dvec3 base = arm.X_WL(0).translation;
  const glm::dvec3 shoulder = arm.X_WL(1).translation;
  const glm::dvec3 elbow = arm.X_WL(3).translation;
  const glm::dvec3 wrist = arm.X_WL(5).translation;
  return {ArmBar{0, {base, shoulder, kUpperArm_m}}, ArmBar{2, {shoulder, elbow, kUpperArm_m}},
          ArmBar{4, {elbow, wrist, kForearm_m}}, ArmBar{6, {wrist, arm.X_WD().translation, kHand_m}}};
}

}  // namespace hug
