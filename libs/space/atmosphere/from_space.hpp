#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "space/atmosphere/tables.hpp"
#include "space/surroundings.hpp"

namespace space {

// The air as an eye outside it sees it: what a picture from an orbit needs of the tables. A ray enters the air at its
// top, so that layer of the scattering is all of it; it ends at the ground, or leaves at the top again.
//
// A ray that misses the Earth's centre by m has the place x among the rows, h = sqrt(top^2 - m^2):
//   ground:  (h - sqrt(bottom^2 - m^2) - least) / (horizon - least), least = top - bottom,
//   sky:     h / horizon.
struct AirFromSpace {
  static constexpr int kThroughRows = 256;
  static constexpr int kGroundSamples = 512;

  AirMapping<float> mapping{Air{}};
  float mie_g = 0.0f;
  float least_mu_s = -1.0f;
  glm::vec3 mie_ratio{0.0f};  // of what aerosols scatter once, against red, where molecules scatter all colours alike
  int num_mu = 2, num_nu = 2, num_mu_s = 1;
  std::vector<glm::vec4> scattering{4, glm::vec4(0.0f)};  // [mu][nu][mu_s], as AirTables
  std::vector<glm::vec3> through;       // what arrives of light from the ray's end: rows of the ground, then of the sky
  std::vector<glm::vec3> ground_light;  // irradiance on level ground: mu_s from least_mu_s to 1

  // No air at all: its light is black, and the ground has that of the sun alone.
  static AirFromSpace Vacuum();
  static AirFromSpace From(const AirTables<float>& tables);
};

// What a ray brings to an eye outside. `miss_m`: how far it passes from the Earth's centre, below the top of the air.
glm::vec3 Through(const AirFromSpace& air, double miss_m);

// The share of the sun's light that arrives: 1 in the open, 0 in the Earth's umbra, between in the penumbra, where the
// air reddens it. The light's path is straight: refraction is left out.
glm::dvec3 SunLight(const Surroundings& space, const AirFromSpace& air);

}  // namespace space
