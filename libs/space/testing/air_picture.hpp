#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "space/atmosphere/air.hpp"
#include "space/atmosphere/shell.hpp"

namespace space {

// A small picture of the Earth's limb from 400 km, the sun's height below growing from left to right through twilight:
// light for a sun of irradiance 1, exposed as 1 - exp(-k L), with a curve of 1 / 2.2 [Bruneton 2017].
using AirView = std::function<glm::dvec3(double r, double mu, double mu_s, double nu, bool meets_ground)>;

constexpr int kAirPictureWidth = 32, kAirPictureHeight = 24;

inline std::vector<double> AirPicture(const Air& air, const AirView& view) {
  const Shell<double> shell{air.bottom_m, air.top_m};
  std::vector<double> picture;
  for (int y = 0; y < kAirPictureHeight; ++y) {
    for (int x = 0; x < kAirPictureWidth; ++x) {
      // From 50 km above the limb to 500 km below it, and the sun from 6 degrees under the horizon to 40 above it.
      const double miss_m = shell.bottom + 50e3 - 550e3 * (y + 0.5) / kAirPictureHeight;
      const double mu = -std::sqrt(1.0 - miss_m * miss_m / (shell.top * shell.top));
      const double sun_rad = -0.1 + 0.8 * (x + 0.5) / kAirPictureWidth, mu_s = std::sin(sun_rad);
      const double turn = 0.3 + 0.07 * y;
      const double nu = mu * mu_s + std::sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * std::cos(turn);
      const glm::dvec3 light = view(shell.top, mu, mu_s, nu, miss_m < shell.bottom);
      for (int k = 0; k < 3; ++k) picture.push_back(255.0 * std::pow(1.0 - std::exp(-10.0 * light[k]), 1.0 / 2.2));
    }
  }
  return picture;
}

// Peak signal-to-noise ratio [dB].
inline double Psnr(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / sum);
}

}  // namespace space
