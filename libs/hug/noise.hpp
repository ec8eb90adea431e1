#pragma once

#include <cstdint>

namespace hug {

// Numbers that look random and are the same in each run: a linear congruential generator [Knuth, MMIX].
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed * 2862933555777941757ULL + 3037000493ULL) {}
  // Even in [0, 1).
  double Even() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  // Mean 0, deviation 1: the sum of twelve even numbers less six, which is normal but for its tails, cut at 6.
  double Normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += Even();
    return sum;
  }

 private:
  std::uint64_t state_;
};

}  // namespace hug
