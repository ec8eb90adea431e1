#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <random>

namespace device_bridge {

// Seeded random numbers that are the same with every standard library: the standard specifies the engine bit for bit,
// but not the distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double Uniform(double least, double greatest) {
    return least + (greatest - least) * (static_cast<double>(engine_() >> 11) * 0x1.0p-53);
  }

  // Standard normal, by Box-Muller: sqrt(-2 ln u) cos(2 pi v). The second number of the pair is discarded, so that
  // every call takes two draws.
  double Gaussian() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(0.0, 1.0)));
    return radius * std::cos(6.283185307179586 * Uniform(0.0, 1.0));
  }

  // Isotropic, with the given root mean square length.
  glm::dvec3 GaussianVector(double rms) {
    const double x = Gaussian();
    const double y = Gaussian();
    const double z = Gaussian();
    return rms / std::sqrt(3.0) * glm::dvec3(x, y, z);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace device_bridge
