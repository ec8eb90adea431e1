#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <random>

#include "core/pose.hpp"

namespace vps {

// Random numbers that are the same on every machine: only the engine is the standard library's, whose distributions are
// not specified to the bit. For tests and benchmarks. Each function draws in a written order; a caller who draws
// several arguments of one call leaves the order to the compiler (GCC draws the last one first).
class CaseRandom {
 public:
  explicit CaseRandom(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  double Unit() { return Uniform(0.0, 1.0); }     // [0, 1)
  double Signed() { return Uniform(-1.0, 1.0); }  // [-1, 1)
  // Approximately normal (Irwin-Hall): the sum of twelve uniform numbers less 6. Mean 0, variance 1, at most 6.
  double Normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += Unit();
    return sum;
  }
  std::size_t Below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  glm::dvec3 InCube() {
    const double z = Signed(), y = Signed(), x = Signed();  // in this order: published cases were drawn so
    return {x, y, z};
  }
  glm::dvec3 Direction() {
    while (true) {
      const glm::dvec3 v = InCube();
      if (glm::length(v) > 0.1 && glm::length(v) < 1.0) return glm::normalize(v);
    }
  }
  glm::dquat Rotation() {
    const glm::dvec3 axis = Direction();
    return core::QuaternionFromRotationVector(Uniform(0.0, 3.1) * axis);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace vps
