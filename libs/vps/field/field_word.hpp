#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace vps {

// One cell of the distance field in 32 bits: the tangent plane of the signed distance at the cell's centre, so that one
// load answers a point anywhere in the cell, d(centre) + g . e.
//
//   bits  0-11  distance at the centre, two's complement, 1/512 voxel (range +-4 voxels)
//   bits 12-20  gradient, octahedral x, 9 bits
//   bits 21-29  gradient, octahedral y, 9 bits
//   bits 30-31  CellKind
//
// A crease cell holds in bits 0-29 the index of its record of four planes (words as above). Bits 30 and 31 of the
// record's first word tell how they combine: with u_k = side * plane_k,
//   distance = side * max(A, B), A of u_0 and u_1, B of u_2 and u_3,
// side = -1 if bit 30 is set; A and B are the smaller of their two if bit 31 is set, else the larger.
enum class CellKind : std::uint32_t {
  kPlane = 0,
  kCrease = 1,
  kCoarse = 2,  // farther than the band: ask the coarse grid
};
constexpr std::uint32_t kCreaseFlipped = 1U << 30;
constexpr std::uint32_t kCreaseNested = 1U << 31;

constexpr std::uint32_t kPlanesPerCrease = 4;
constexpr float kDistanceSteps = 512.0f;  // per voxel
constexpr float kLargestWordDistance = 2047.0f / kDistanceSteps;

// Octahedral map of a unit vector onto the square [-1, 1]^2 (Meyer et al. 2010): project onto |x|+|y|+|z| = 1 and fold
// the lower half outwards.
inline glm::vec2 OctahedralFromUnit(const glm::vec3& n) {
  const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
  const glm::vec2 p(n.x / sum, n.y / sum);
  if (n.z >= 0.0f) return p;
  return {(1.0f - std::abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f), (1.0f - std::abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f)};
}

// 1/sqrt(u) for u in [1/3, 1], the squared lengths that unfolding gives: the quartic of least relative error, 7e-4. The
// same operations in the same order in every kernel, so that all give the same bits.
constexpr float kRootC0 = 3.2490766f, kRootC1 = -7.3330532f, kRootC2 = 10.7539954f, kRootC3 = -8.0507022f,
                kRootC4 = 2.3813827f;

template <class Float>  // float or a vector of floats
inline Float InverseRootOfOctahedral(Float u) {
  return kRootC0 + u * (kRootC1 + u * (kRootC2 + u * (kRootC3 + u * kRootC4)));
}

// (x, y) in [-1, 1]^2 to a unit vector.
inline glm::vec3 UnitFromOctahedral(float x, float y) {
  const float z = (1.0f - std::abs(x)) - std::abs(y);
  const float fold = std::max(-z, 0.0f);
  x = x >= 0.0f ? x - fold : x + fold;
  y = y >= 0.0f ? y - fold : y + fold;
  const float scale = InverseRootOfOctahedral((x * x + y * y) + z * z);
  return {x * scale, y * scale, z * scale};
}

// Steps of the 9-bit code: 510, not 511, so that 0 and the axes are exact.
constexpr float kOctahedralSteps = 255.0f;

inline std::uint32_t EncodePlane(float distance_voxels, const glm::vec3& gradient) {
  const float d = std::clamp(distance_voxels, -kLargestWordDistance, kLargestWordDistance);
  const glm::vec2 o = OctahedralFromUnit(gradient);
  const auto code = [](float c) { return static_cast<std::uint32_t>(std::lround((c + 1.0f) * kOctahedralSteps)); };
  return (static_cast<std::uint32_t>(std::lround(d * kDistanceSteps)) & 0xfffU) | code(o.x) << 12 | code(o.y) << 21;
}

inline CellKind KindOf(std::uint32_t word) {
  return static_cast<CellKind>(word >> 30);
}
inline float DistanceOf(std::uint32_t word) {
  return static_cast<float>(static_cast<std::int32_t>(word << 20) >> 20) * (1.0f / kDistanceSteps);
}
inline glm::vec3 GradientOf(std::uint32_t word) {
  const auto decode = [](std::uint32_t code) {
    return static_cast<float>(static_cast<std::int32_t>(code)) * (1.0f / kOctahedralSteps) - 1.0f;
  };
  return UnitFromOctahedral(decode(word >> 12 & 0x1ffU), decode(word >> 21 & 0x1ffU));
}

// Gradients of the coarse grid: two 16-bit octahedral codes.
constexpr float kCoarseOctahedralSteps = 32767.0f;

inline std::uint32_t EncodeCoarseGradient(const glm::vec3& gradient) {
  const glm::vec2 o = OctahedralFromUnit(gradient);
  const auto code = [](float c) {
    return static_cast<std::uint32_t>(std::lround((c + 1.0f) * kCoarseOctahedralSteps));
  };
  return code(o.x) | code(o.y) << 16;
}
inline glm::vec3 CoarseGradientOf(std::uint32_t code) {
  const auto decode = [](std::uint32_t c) {
    return static_cast<float>(static_cast<std::int32_t>(c)) * (1.0f / kCoarseOctahedralSteps) - 1.0f;
  };
  return UnitFromOctahedral(decode(code & 0xffffU), decode(code >> 16));
}

}  // namespace vps
