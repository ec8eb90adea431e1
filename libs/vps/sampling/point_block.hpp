#pragma once

#include <cstdint>

namespace vps {

// Sixteen points: one AVX-512 register, two of AVX2, four of SSE.
constexpr std::uint32_t kBlock = 16;

struct alignas(64) PointBlock {
  float x[kBlock], y[kBlock], z[kBlock];     // mesh frame, m
  float nx[kBlock], ny[kBlock], nz[kBlock];  // inward normals (SurfaceSamples)
  float area_m2[kBlock];
};

}  // namespace vps
