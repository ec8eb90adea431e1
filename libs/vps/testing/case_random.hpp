#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <random>

#include "core/pose.hpp"

namespace vps {

// Random numbers that are the same on every machine: only the engine is the standard library's, whose distributions are
// not specified to the bit. For tests and benchmarks.
class CaseRandom {
 public:
  explicit CaseRandom(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  double Unit() { return Uniform(0.0, 1.0); }     // [0, 1)
  double Signed() { return Uniform(-1.0, 1.0); }  // [-1, 1)
  glm::dvec3 InCube() { return {Signed(), Signed(), Signed()}; }
  std::size_t Below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
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

}  // namespace vps
