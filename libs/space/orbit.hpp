#pragma once

#include <glm/glm.hpp>

namespace space {

constexpr double kEarthRadius_m = 6'378'137.0;      // at the equator, WGS 84
constexpr double kEarthMeanRadius_m = 6'371'008.8;  // of the sphere that is drawn, IUGG
constexpr double kMoonRadius_m = 1'737'400.0;
constexpr double kEarthGm_m3_per_s2 = 3.986004418e14;

// A circular orbit about a round Earth. Angles refer to the equator of the celestial frame C.
struct Orbit {
  double altitude_m = 400e3;  // above the equator's radius
  double inclination_rad = 0.0;
  double node_rad = 0.0;      // right ascension of the ascending node
  double argument_rad = 0.0;  // from the node to the position at the epoch, along the orbit

  [[nodiscard]] double period_s() const;
  // From the Earth's centre [m], that many seconds after the epoch.
  [[nodiscard]] glm::dvec3 Position_C(double seconds) const;
};

}  // namespace space
