#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/pose.hpp"
#include "space/instant.hpp"
#include "space/place.hpp"

namespace space {

// All that is far away, as seen from the scene at one moment. Its defaults are no moment: the sun above, the Earth far
// below.
struct Surroundings {
  Instant instant;
  glm::dvec3 sun_direction_W{0.0, 0.0, 1.0};
  glm::dvec3 moon_position_W{0.0};  // [m]
  core::Pose X_WE{{1.0, 0.0, 0.0, 0.0},
                  {0.0, 0.0, -4.2e7}};  // of the Earth's frame: z the pole, x Greenwich on the equator
  glm::dquat R_WC{1.0, 0.0, 0.0, 0.0};  // celestial frame: the stars
};

// Sees the same place at many moments. The sun, the Moon and the pole are computed anew when they are kSlow_s old: the
// fastest of them, the Moon, moves by 0.002 degrees in that time.
class Observer {
 public:
  explicit Observer(const Place& place);

  Surroundings At(double seconds_after_epoch);

  static constexpr double kSlow_s = 10.0;

 private:
  void Renew(double seconds);

  Place place_;
  glm::dquat R_WC_{1.0, 0.0, 0.0, 0.0};
  double renewed_s_ = 0.0;
  glm::dvec3 sun_C_{0.0};
  glm::dvec3 moon_C_{0.0};
  glm::dmat3 R_CI_{1.0};
};

}  // namespace space
