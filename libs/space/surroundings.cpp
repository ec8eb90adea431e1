#include "space/surroundings.hpp"

#include <cmath>

#include "space/almanac.hpp"

namespace space {
namespace {

// Axes from two directions: x along the first, y in their plane (TRIAD, [Black 1964]).
glm::dmat3 AxesOf(const glm::dvec3& first, const glm::dvec3& second) {
  const glm::dvec3 x = glm::normalize(first);
  const glm::dvec3 z = glm::normalize(glm::cross(x, second));
  return {x, glm::cross(z, x), z};
}

}  // namespace

Observer::Observer(const Place& place) : place_(place) {
  Renew(0.0);
  const glm::dmat3 R_WA = AxesOf(place.sun_W, place.zenith_W);
  const glm::dmat3 R_CA = AxesOf(sun_C_, place.orbit.Position_C(0.0));
  R_WC_ = glm::normalize(glm::quat_cast(R_WA * glm::transpose(R_CA)));
}

void Observer::Renew(double seconds) {
  const Instant instant = After(place_.epoch, seconds);
  sun_C_ = SunDirection_C(instant);
  moon_C_ = MoonPosition_C(instant);
  R_CI_ = CelestialPole(instant);
  renewed_s_ = seconds;
}

Surroundings Observer::At(double seconds_after_epoch) {
  if (std::abs(seconds_after_epoch - renewed_s_) > kSlow_s) Renew(seconds_after_epoch);
  Surroundings seen;
  seen.instant = After(place_.epoch, seconds_after_epoch);
  const glm::dvec3 position_C = place_.orbit.Position_C(seconds_after_epoch);
  const double angle = EarthRotationAngle_rad(seen.instant);
  const glm::dquat R_IE = glm::angleAxis(angle, glm::dvec3(0.0, 0.0, 1.0));
  seen.sun_direction_W = R_WC_ * sun_C_;  // the sun's parallax across an orbit is below 0.003 degrees
  seen.moon_position_W = R_WC_ * (moon_C_ - position_C);
  seen.X_WE = {glm::normalize(R_WC_ * glm::quat_cast(R_CI_) * R_IE), -(R_WC_ * position_C)};
  seen.R_WC = R_WC_;
  return seen;
}

}  // namespace space
