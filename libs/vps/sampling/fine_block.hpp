#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "vps/sampling/surface_panels.hpp"

namespace vps {

// Sixteen points: one AVX-512 register, two of AVX2, four of SSE.
constexpr std::uint32_t kBlock = 16;

struct alignas(64) PointBlock {
  float x[kBlock], y[kBlock], z[kBlock];     // mesh frame, m
  float nx[kBlock], ny[kBlock], nz[kBlock];  // inward normals (SurfaceSamples)
  float area_m2[kBlock];
};

// Refinement of one sample's patch into up to sixteen finer points, for contacts of few samples (decision 9). Packed,
// since there is one for every sample: places and normals relative to the sample's, areas as shares of its own.
struct alignas(64) FineBlock {
  std::int16_t x[kBlock], y[kBlock], z[kBlock];    // from the sample, in steps of place_step_m
  std::int8_t nx[kBlock], ny[kBlock], nz[kBlock];  // from its normal, in steps of normal_step
  std::uint16_t share[kBlock];                     // of its area, in 1 / kShares; they add up to kShares
  float place_step_m = 0.0f;
  float normal_step = 0.0f;
  float reach_m = 0.0f;  // radius of the sample's patch about the sample
  float cover_m = 0.0f;  // covering radius: no place of the patch is farther from the nearest of these points
};
static_assert(sizeof(FineBlock) == 192);
constexpr float kShares = 65535.0f;

// Typical radius of a patch over the root of its area: a regular hexagon has 0.62 (radius of its corners), patches have
// longer corners. Not derived further.
constexpr float kPatchReach = 0.7f;

// Groups the panels of a sample's patch (indices into `panels`; reordered) into sixteen compact groups of about equal
// numbers of panels. p [m] and inward_normal: the sample's.
FineBlock MakeFineBlock(const std::vector<SurfacePanel>& panels, std::span<std::uint32_t> cell, const glm::dvec3& p,
                        const glm::dvec3& inward_normal);

// The points of a sample, `at` of its block; areas are multiplied by `weight`.
void Unpack(const FineBlock& fine, const PointBlock& block, std::uint32_t at, float weight, PointBlock* points);

}  // namespace vps
