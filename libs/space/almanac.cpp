#include "space/almanac.hpp"

#include <erfa.h>
#include <erfam.h>

#include <cmath>

namespace space {
namespace {

struct Date {  // Julian date in two parts
  double day = 0.0;
  double fraction = 0.0;
};

// Terrestrial Time. ERFA's ephemerides want TDB, which differs from it by at most 2 ms.
Date TerrestrialTime(const Instant& instant) {
  Date tai, tt;
  eraUtctai(instant.utc1, instant.utc2, &tai.day, &tai.fraction);
  eraTaitt(tai.day, tai.fraction, &tt.day, &tt.fraction);
  return tt;
}

glm::dvec3 ToVec(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

}  // namespace

glm::dvec3 SunDirection_C(const Instant& instant) {
  const Date tt = TerrestrialTime(instant);
  double heliocentric[2][3], barycentric[2][3];  // of the Earth: position [au], velocity [au / day]
  eraEpv00(tt.day, tt.fraction, heliocentric, barycentric);
  const double distance_au = glm::length(ToVec(heliocentric[0]));
  const glm::dvec3 natural = -ToVec(heliocentric[0]) / distance_au;
  // In the light time of 500 s the sun itself moves by 0.01 arc seconds, so its geometric place is its natural one.
  const glm::dvec3 velocity = ToVec(barycentric[1]) * (ERFA_DAU / ERFA_DAYSEC / ERFA_CMPS);  // in units of light's
  double natural_direction[3] = {natural.x, natural.y, natural.z};
  double beta[3] = {velocity.x, velocity.y, velocity.z};
  double proper[3];
  eraAb(natural_direction, beta, distance_au, std::sqrt(1.0 - glm::dot(velocity, velocity)), proper);
  return glm::normalize(ToVec(proper));
}

glm::dvec3 MoonPosition_C(const Instant& instant) {
  const Date tt = TerrestrialTime(instant);
  double moon[2][3];
  eraMoon98(tt.day, tt.fraction, moon);
  return ERFA_DAU * ToVec(moon[0]);
}

glm::dmat3 CelestialPole(const Instant& instant) {
  const Date tt = TerrestrialTime(instant);
  double R_IC[3][3];
  eraC2i06a(tt.day, tt.fraction, R_IC);
  // ERFA's rows are R_IC's, so as columns they are those of R_CI.
  return {ToVec(R_IC[0]), ToVec(R_IC[1]), ToVec(R_IC[2])};
}

double EarthRotationAngle_rad(const Instant& instant) {
  return eraEra00(instant.utc1, instant.utc2);
}

glm::dmat3 EarthOrientation_C(const Instant& instant) {
  const double angle = EarthRotationAngle_rad(instant);
  const double c = std::cos(angle), s = std::sin(angle);
  return CelestialPole(instant) * glm::dmat3(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
}

}  // namespace space
