#include "space/orbit.hpp"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace space {

// Kepler's third law.
double Orbit::period_s() const {
  const double radius_m = kEarthRadius_m + altitude_m;
  return glm::two_pi<double>() * std::sqrt(radius_m * radius_m * radius_m / kEarthGm_m3_per_s2);
}

glm::dvec3 Orbit::Position_C(double seconds) const {
  const double u = argument_rad + glm::two_pi<double>() * seconds / period_s();
  const glm::dvec3 to_node(std::cos(node_rad), std::sin(node_rad), 0.0);
  const glm::dvec3 ahead(-std::sin(node_rad) * std::cos(inclination_rad),
                         std::cos(node_rad) * std::cos(inclination_rad), std::sin(inclination_rad));
  return (kEarthRadius_m + altitude_m) * (std::cos(u) * to_node + std::sin(u) * ahead);
}

}  // namespace space
