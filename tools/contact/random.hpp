#pragma once

#include <cstdint>
#include <random>

#include "core/pose.hpp"

namespace contact {

// Random numbers that are the same on every machine: only the engine is the standard library's, whose distributions are
// not specified to the bit.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  // Approximately normal (Irwin-Hall): the sum of twelve uniform numbers less 6. Mean 0, variance 1, at most 6.
  double Normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += Uniform(0.0, 1.0);
    return sum;
  }
  glm::dvec3 Direction() {
    while (true) {
      const glm::dvec3 v(Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1));
      if (glm::length(v) > 0.1 && glm::length(v) < 1.0) return glm::normalize(v);
    }
  }
  glm::dquat Rotation() { return core::QuaternionFromRotationVector(Uniform(0.0, 3.1) * Direction()); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace contact
