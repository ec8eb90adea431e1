#pragma once

#include <cstdint>

namespace view {

// The same number for the same lattice point and layer, in [-1, 1]: a hash.
inline float LatticeNoise(int x, int y, std::uint32_t layer) {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x9E3779B1u ^ static_cast<std::uint32_t>(y) * 0x85EBCA77u ^ layer * 0xC2B2AE3Du;
  h = (h ^ h >> 15) * 0x2C1B3C6Du;
  h = (h ^ h >> 12) * 0x297A2D39u;
  h ^= h >> 15;
  return static_cast<float>(h & 0xffffu) / 32767.5f - 1.0f;
}

}  // namespace view
