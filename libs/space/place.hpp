#pragma once

#include <glm/glm.hpp>

#include "space/instant.hpp"
#include "space/orbit.hpp"

namespace space {

// Where a scene is and how it is turned. The world frame W keeps its attitude to the stars. At the epoch the sun stands
// in the direction sun_W, and the zenith is turned about it until it is as near as it can be to zenith_W.
//
// Defaults, chosen by eye: high enough that the Earth is seen whole, day over the Sudan.
struct Place {
  Instant epoch{2457452.5, 0.5};                                     // 2016-03-05T12:00:00Z
  Orbit orbit{8300e3, 0.9005898940290741, 0.0, 0.3665191429188092};  // 51.6 degrees of inclination, 21 of argument
  glm::dvec3 sun_W{0.3, 0.4, 0.85};                                  // need not be unit
  glm::dvec3 zenith_W{0.82, -0.27, 0.50};                            // need not be unit; not along sun_W
};

}  // namespace space
