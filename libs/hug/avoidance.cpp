#include "hug/avoidance.hpp"

#include <algorithm>

namespace hug {
namespace {

double Speed(const Joints& unit, const Joints& speed) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kJoints; ++i) sum += unit[i] * speed[i];
  return sum;
}

// Push along n, apart: k (begin - d) + b max(approach, 0).
double Push_N(const Avoidance& avoidance, double distance_m, double approach_m_per_s) {
  return avoidance.stiffness_N_per_m * (avoidance.begins_m - distance_m) +
         avoidance.damping_N_s_per_m * std::max(approach_m_per_s, 0.0);
}

// From the second to the first; when the segments cross, upwards.
glm::dvec3 Apart(const ClosestPoints& closest) {
  const glm::dvec3 r = closest.on_first - closest.on_second;
  const double length_m = glm::length(r);
  return length_m > 1e-9 ? r / length_m : glm::dvec3(0.0, 0.0, 1.0);
}

}  // namespace

AvoidanceResult AvoidEachOther(const Avoidance& avoidance, const ArmDynamics& first, const Joints& first_speed,
                               const ArmDynamics& second, const Joints& second_speed) {
  AvoidanceResult result;
  const ArmBars bars = BarsOf(first), others = BarsOf(second);
  for (const ArmBar& bar : bars) {
    for (const ArmBar& other : others) {
      if (bar.link == 0 && other.link == 0) continue;  // both stand still
      const ClosestPoints closest = Closest(bar.capsule, other.capsule);
      result.least_m = std::min(result.least_m, closest.distance_m);
      if (closest.distance_m >= avoidance.begins_m) continue;
      const glm::dvec3 apart = Apart(closest);
      const Joints one = first.TorquesOf(bar.link, closest.on_first, apart);
      const Joints two = second.TorquesOf(other.link, closest.on_second, -apart);
      const double push_N = Push_N(avoidance, closest.distance_m, -Speed(one, first_speed) - Speed(two, second_speed));
      result.first = result.first + push_N * one;
      result.second = result.second + push_N * two;
    }
  }
  return result;
}

AvoidanceResult AvoidBodies(const Avoidance& avoidance, const ArmDynamics& arm, const Joints& speed,
                            std::span<const Capsule> bodies) {
  AvoidanceResult result;
  for (const ArmBar& bar : BarsOf(arm)) {
    if (bar.link == 0) continue;
    for (const Capsule& body : bodies) {
      const ClosestPoints closest = Closest(bar.capsule, body);
      result.least_m = std::min(result.least_m, closest.distance_m);
      if (closest.distance_m >= avoidance.begins_m) continue;
      const Joints one = arm.TorquesOf(bar.link, closest.on_first, Apart(closest));
      result.first = result.first + Push_N(avoidance, closest.distance_m, -Speed(one, speed)) * one;
    }
  }
  return result;
}

}  // namespace hug
