#include "space/almanac.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <glm/gtc/constants.hpp>
#include <sstream>
#include <vector>

#include "space/surroundings.hpp"

namespace space {
namespace {

// The figure that the pictures keep.
constexpr double kLimit_deg = 0.02;

struct Row {
  Instant instant;
  glm::dvec3 sun_C;
  glm::dvec3 moon_C_m;
  glm::dmat3 R_CE;
};

// See almanac_table.py.
std::vector<Row> ReadTable() {
  std::ifstream file(std::string(VR_OOS_SOURCE_DIR) + "/libs/space/testing/almanac.csv");
  std::vector<Row> rows;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#' || line[0] == 'u') continue;
    std::stringstream fields(line);
    std::string field;
    std::getline(fields, field, ',');
    const auto instant = ParseInstant(field);
    EXPECT_TRUE(instant) << field;
    double v[15] = {};
    for (double& value : v) {
      std::getline(fields, field, ',');
      value = std::stod(field);
    }
    rows.push_back({*instant,
                    {v[0], v[1], v[2]},
                    1e3 * glm::dvec3(v[3], v[4], v[5]),
                    {v[6], v[9], v[12], v[7], v[10], v[13], v[8], v[11], v[14]}});
  }
  return rows;
}

double Angle_deg(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

void ExpectBelow(double limit_deg, const char* name, double angle_deg) {
  EXPECT_LT(angle_deg, limit_deg) << name;
  testing::Test::RecordProperty(name, std::to_string(angle_deg));
}

TEST(Almanac, SunMoonEarthAndTerminatorAgreeWithAnotherAlmanacOverAYear) {
  const std::vector<Row> rows = ReadTable();
  ASSERT_EQ(rows.size(), 74U);
  double sun_deg = 0.0, moon_deg = 0.0, earth_deg = 0.0, terminator_deg = 0.0;
  for (const Row& row : rows) {
    const glm::dvec3 sun_C = SunDirection_C(row.instant);
    const glm::dmat3 R_CE = EarthOrientation_C(row.instant);
    sun_deg = std::max(sun_deg, Angle_deg(sun_C, row.sun_C));
    moon_deg = std::max(moon_deg, Angle_deg(MoonPosition_C(row.instant), row.moon_C_m));
    for (int axis = 0; axis < 3; ++axis) earth_deg = std::max(earth_deg, Angle_deg(R_CE[axis], row.R_CE[axis]));
    // The terminator is the great circle around the point below the sun.
    terminator_deg =
        std::max(terminator_deg, Angle_deg(glm::transpose(R_CE) * sun_C, glm::transpose(row.R_CE) * row.sun_C));
    EXPECT_NEAR(glm::length(MoonPosition_C(row.instant)) / glm::length(row.moon_C_m), 1.0, 1e-3);
  }
  ExpectBelow(kLimit_deg, "sun_deg", sun_deg);
  ExpectBelow(kLimit_deg, "moon_deg", moon_deg);
  ExpectBelow(kLimit_deg, "earth_deg", earth_deg);
  ExpectBelow(kLimit_deg, "terminator_deg", terminator_deg);
}

TEST(Almanac, TheEarthTurnsOnceInASiderealDay) {
  const Instant noon = *ParseInstant("2016-03-05T12:00:00Z");
  const double turned_deg = Angle_deg(EarthOrientation_C(noon)[0], EarthOrientation_C(After(noon, 86164.0905))[0]);
  EXPECT_LT(turned_deg, 1e-3);
}

TEST(Instant, CountsLeapSeconds) {
  const Instant before = *ParseInstant("2016-12-31T23:59:59Z");
  EXPECT_EQ(FormatInstant(After(before, 1.0)), "2016-12-31 23:59:60 UTC");
  EXPECT_EQ(FormatInstant(After(before, 2.0)), "2017-01-01 00:00:00 UTC");
}

TEST(Orbit, APassAt400kmTakes92Minutes) {
  const Orbit orbit{400e3, 0.9, 0.3, 0.2};
  EXPECT_NEAR(orbit.period_s() / 60.0, 92.56, 0.01);
  EXPECT_NEAR(glm::distance(orbit.Position_C(orbit.period_s()), orbit.Position_C(0.0)), 0.0, 1.0);
  const glm::dvec3 axis = glm::normalize(glm::cross(orbit.Position_C(0.0), orbit.Position_C(60.0)));
  EXPECT_NEAR(std::acos(axis.z), 0.9, 1e-9);
  EXPECT_NEAR(std::atan2(axis.x, -axis.y), 0.3, 1e-9);
}

TEST(Observer, TheSunStandsWhereTheSceneWantsItAndTheZenithIsNear) {
  Place place;
  place.sun_W = {0.35, -0.45, 0.8};
  Observer observer(place);
  const Surroundings seen = observer.At(0.0);
  EXPECT_LT(Angle_deg(seen.sun_direction_W, place.sun_W), 1e-9);
  const glm::dvec3 zenith_W = -seen.X_WE.translation;
  const double sun_to_zenith_deg = Angle_deg(seen.sun_direction_W, zenith_W);
  EXPECT_NEAR(Angle_deg(zenith_W, place.zenith_W), std::abs(sun_to_zenith_deg - Angle_deg(place.sun_W, place.zenith_W)),
              1e-9);
  EXPECT_NEAR(glm::length(zenith_W), kEarthRadius_m + place.orbit.altitude_m, 1e-3);
}

// The reference is the almanac without the observer's shortcuts: nothing kept from an earlier moment, frames turned by
// matrices.
TEST(Observer, SunEarthAndTerminatorAreThoseOfTheMomentThroughAnOrbit) {
  Place place;
  place.orbit.altitude_m = 400e3;
  Observer observer(place);
  const glm::dmat3 R_WC = glm::mat3_cast(observer.At(0.0).R_WC);
  double sun_deg = 0.0, earth_deg = 0.0, moon_deg = 0.0;
  for (double t = 0.0; t < place.orbit.period_s(); t += 7.3) {
    const Surroundings seen = observer.At(t);
    const Instant instant = After(place.epoch, t);
    sun_deg = std::max(sun_deg, Angle_deg(seen.sun_direction_W, R_WC * SunDirection_C(instant)));
    const glm::dmat3 R_WE = R_WC * EarthOrientation_C(instant);
    for (int axis = 0; axis < 3; ++axis) {
      earth_deg = std::max(earth_deg, Angle_deg(glm::mat3_cast(seen.X_WE.rotation)[axis], R_WE[axis]));
    }
    const glm::dvec3 moon_W = R_WC * (MoonPosition_C(instant) - place.orbit.Position_C(t));
    moon_deg = std::max(moon_deg, Angle_deg(seen.moon_position_W, moon_W));
  }
  ExpectBelow(0.001, "sun_deg", sun_deg);
  ExpectBelow(0.001, "earth_deg", earth_deg);
  ExpectBelow(0.005, "moon_deg", moon_deg);
}

TEST(Observer, TheGroundPassesBelowAsFastAsTheOrbitAndTheEarthTurn) {
  Place place;
  place.orbit.inclination_rad = 0.0;  // eastwards along the equator
  Observer observer(place);
  const auto longitude_rad = [](const Surroundings& seen) {
    const glm::dvec3 p_E = seen.X_WE.inverse().translation;
    return std::atan2(p_E.y, p_E.x);
  };
  const double passed_rad = longitude_rad(observer.At(60.0)) - longitude_rad(observer.At(0.0));
  const double expected_rad = glm::two_pi<double>() * 60.0 * (1.0 / place.orbit.period_s() - 1.0 / 86164.1);
  EXPECT_NEAR(passed_rad, expected_rad, 1e-5);
}

}  // namespace
}  // namespace space
