#include "view/appearance/environment_light.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "space/orbit.hpp"

namespace view {
namespace {

glm::vec3 Evaluate(const std::array<glm::vec3, 9>& c, const glm::vec3& n) {
  return c[0] + n.y * c[1] + n.z * c[2] + n.x * c[3] + n.x * n.y * c[4] + n.y * n.z * c[5] +
         (3.0f * n.z * n.z - 1.0f) * c[6] + n.x * n.z * c[7] + (n.x * n.x - n.y * n.y) * c[8];
}

// 400 km above the place where the sun stands in the zenith.
EnvironmentLight Noon() {
  space::Surroundings space;
  space.sun_direction_W = {0.0, 0.0, 1.0};
  space.X_WE.translation = {0.0, 0.0, -(space::kEarthMeanRadius_m + 4e5)};
  return LightOf(space);
}

TEST(EnvironmentLight, AMattWallReflectsUniformLightWhole) {
  EnvironmentLight light;
  light.everywhere = glm::vec3(0.7f);
  for (const glm::vec3 n : {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0.8f, 0), glm::vec3(-0.48f, 0.6f, 0.64f)}) {
    EXPECT_NEAR(Evaluate(Irradiance(light), n).g, 0.7f, 1e-3f);
  }
}

// Degree 2 keeps 99 % of a distant source's energy and misses a single direction by at most 9 % of the strongest
// [Ramamoorthi and Hanrahan 2001].
TEST(EnvironmentLight, TheIrradianceIsThatOfTheRadianceWithinNinePercent) {
  const EnvironmentLight light = Noon();
  const auto coefficients = Irradiance(light);
  const double strongest = Evaluate(coefficients, {0, 0, -1}).b;
  for (const glm::vec3 n : {glm::vec3(0, 0, -1), glm::vec3(1, 0, 0), glm::vec3(0, 0, 1), glm::vec3(0.6f, 0, -0.8f)}) {
    double sum = 0.0;
    constexpr int kNumDirections = 20000;
    for (int i = 0; i < kNumDirections; ++i) {
      const double z = 1.0 - (2.0 * i + 1.0) / kNumDirections, ring = std::sqrt(1.0 - z * z),
                   turn = 2.399963229728653 * i;
      const glm::vec3 d(ring * std::cos(turn), ring * std::sin(turn), z);
      sum += 4.0 / kNumDirections * std::max(0.0f, glm::dot(d, n)) * light.Radiance(d).b;
    }
    EXPECT_NEAR(Evaluate(coefficients, n).b, sum, 0.09 * strongest);
  }
}

TEST(EnvironmentLight, TheEarthShinesFromBelowAndNotFromBeyondItsLimb) {
  const EnvironmentLight light = Noon();
  EXPECT_GT(light.Radiance({0, 0, -1}).b, 0.3f);
  const float limb_rad = std::asin(light.earth_sine);
  const auto off = [&](float angle_rad) { return glm::vec3(std::sin(angle_rad), 0.0f, -std::cos(angle_rad)); };
  EXPECT_GT(light.Radiance(off(limb_rad - 0.01f)).b - light.Radiance(off(limb_rad + 0.01f)).b, 0.1f);
}

TEST(EnvironmentLight, TheSunIsGoneInTheEarthsShadow) {
  space::Surroundings space;
  space.X_WE.translation = {0.0, 0.0, -(space::kEarthMeanRadius_m + 4e5)};
  const double limb_rad = std::asin(space::kEarthMeanRadius_m / (space::kEarthMeanRadius_m + 4e5));
  const auto sun = [&](double above_rad) {
    const double angle = limb_rad + above_rad;  // from the Earth's centre
    space.sun_direction_W = {std::sin(angle), 0.0, -std::cos(angle)};
    return LightOf(space).sun.g;
  };
  EXPECT_EQ(sun(-0.005), 0.0f);
  EXPECT_NEAR(sun(0.005), 3.14159265f, 1e-5f);
  EXPECT_NEAR(sun(0.0), 0.5f * sun(0.005), 0.01f);
}

}  // namespace
}  // namespace view
