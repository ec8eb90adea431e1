#pragma once

#include <array>
#include <glm/glm.hpp>

#include "space/atmosphere/from_space.hpp"
#include "space/surroundings.hpp"

namespace view {

using space::kSunRadius_rad;

const glm::vec3 kSunColor(1.02f, 1.0f, 0.96f);  // of a white wall that faces the sun

// The light around the scene, in the film's unit: a white wall that faces the sun has radiance 1.
struct EnvironmentLight {
  glm::vec3 sun_direction_W{0.0f, 0.0f, 1.0f};
  glm::vec3 sun{0.0f};  // irradiance across its direction; what of it the Earth and its air leave
  glm::vec3 earth_direction_W{0.0f, 0.0f, -1.0f};
  float earth_sine = 0.1f;     // of the Earth's angular radius
  glm::vec3 earth{0.0f};       // radiance of its ground where the sun stands in the zenith
  glm::vec3 panels{0.0f};      // radiance of the servicer's two light panels (kPanels)
  glm::vec3 everywhere{0.0f};  // from all directions

  // Radiance from a direction d_W.
  [[nodiscard]] glm::vec3 Radiance(const glm::vec3& d_W) const;

  bool operator==(const EnvironmentLight&) const = default;
};

// A panel shines from within `inner` of its direction, and from none beyond `outer`: cosines.
struct LightPanel {
  glm::vec3 direction_W;
  float outer;
  float inner;
  float strength;
};
// By eye: without them a surface in the sun's shadow that faces away from the Earth is black.
constexpr std::array<LightPanel, 2> kPanels = {
    {{{0.2521f, -0.6555f, 0.7120f}, 0.20f, 0.95f, 0.70f}, {{-0.7455f, 0.2485f, 0.6184f}, 0.30f, 0.98f, 0.40f}}};

EnvironmentLight LightOf(const space::Surroundings& space,
                         const space::AirFromSpace& air = space::AirFromSpace::Vacuum());

// What a matt white surface with the normal n reflects of the light around: a polynomial of degree 2 in n, with these
// coefficients of 1, y, z, x, xy, yz, 3 z^2 - 1, xz, x^2 - y^2 [Ramamoorthi and Hanrahan 2001].
std::array<glm::vec3, 9> Irradiance(const EnvironmentLight& light);

}  // namespace view
