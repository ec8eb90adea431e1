#include "view/appearance/environment_light.hpp"

#include <algorithm>
#include <cmath>

#include "space/orbit.hpp"

namespace view {
namespace {

// Mean reflectance of ground, sea and clouds: 0.30, the Earth's Bond albedo, bluish by the air.
const glm::vec3 kEarthAlbedo(0.26f, 0.30f, 0.36f);
const glm::vec3 kPanelColor(1.0f, 0.98f, 0.94f);
const glm::vec3 kEverywhere(0.050f, 0.052f, 0.056f);  // by eye: of the servicer, which is not drawn

}  // namespace

EnvironmentLight LightOf(const space::Surroundings& space, const space::AirFromSpace& air) {
  EnvironmentLight light;
  const double distance_m = glm::length(space.X_WE.translation);
  const double sine = std::min(1.0, space::kEarthMeanRadius_m / distance_m);
  light.sun_direction_W = glm::vec3(space.sun_direction_W);
  light.sun = glm::vec3(std::acos(-1.0) * space::SunLight(space, air)) * kSunColor;
  light.earth_direction_W = glm::vec3(space.X_WE.translation / distance_m);
  light.earth_sine = static_cast<float>(sine);
  light.earth = kEarthAlbedo;
  light.panels = kPanelColor;
  light.everywhere = kEverywhere;
  return light;
}

// As Environment() of the surface shader for a mirror.
glm::vec3 EnvironmentLight::Radiance(const glm::vec3& d_W) const {
  glm::vec3 sum = everywhere;
  for (const LightPanel& panel : kPanels) {
    sum += panels * panel.strength * glm::smoothstep(panel.outer, panel.inner, glm::dot(d_W, panel.direction_W));
  }
  const float along = glm::dot(d_W, earth_direction_W);
  const float rest = earth_sine * earth_sine - (1.0f - along * along);
  if (along <= 0.0f || rest <= 0.0f) return sum;
  const glm::vec3 n = (d_W * (along - std::sqrt(rest)) - earth_direction_W) / earth_sine;
  return sum + earth * std::max(0.0f, glm::dot(n, sun_direction_W));
}

std::array<glm::vec3, 9> Irradiance(const EnvironmentLight& light) {
  constexpr int kNumDirections = 1024;  // on a spiral that covers the sphere evenly
  constexpr float kGolden_rad = 2.399963229728653f;
  // Of the products of each harmonic with itself, and of the cosine lobe's shares 1, 2/3, 1/4.
  constexpr float kWeights[9] = {
      0.282095f * 0.282095f,         0.488603f * 0.488603f * 2 / 3, 0.488603f * 0.488603f * 2 / 3,
      0.488603f * 0.488603f * 2 / 3, 1.092548f * 1.092548f / 4,     1.092548f * 1.092548f / 4,
      0.315392f * 0.315392f / 4,     1.092548f * 1.092548f / 4,     0.546274f * 0.546274f / 4};
  std::array<glm::vec3, 9> sums{};
  for (int i = 0; i < kNumDirections; ++i) {
    const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / kNumDirections;
    const float ring = std::sqrt(1.0f - z * z), turn = kGolden_rad * static_cast<float>(i);
    const float x = ring * std::cos(turn), y = ring * std::sin(turn);
    const glm::vec3 radiance = light.Radiance({x, y, z});
    const float harmonics[9] = {1.0f, y, z, x, x * y, y * z, 3.0f * z * z - 1.0f, x * z, x * x - y * y};
    for (std::size_t k = 0; k < 9; ++k) sums[k] += radiance * harmonics[k];
  }
  constexpr float kSolidAngle = 4.0f * 3.14159265f / kNumDirections;
  for (std::size_t k = 0; k < 9; ++k) sums[k] *= kSolidAngle * kWeights[k];
  return sums;
}

}  // namespace view
