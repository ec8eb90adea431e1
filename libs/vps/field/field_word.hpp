#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace vps {

// One cell of the distance field in 32 bits: the tangent plane of the signed distance at the cell's centre, so that one
// load answers a point anywhere in the cell, d(centre) + g . e.
//
//   bits 21-31  distance at the centre, two's complement, 1/256 voxel (range +-4 voxels)
//   bits 14-20  gradient x, two's complement, 1/63
//   bits  7-13  gradient y
//   bits  0-6   gradient z
//
// The distance is read from the whole word as one integer, so the gradient's bits are its fraction: the encoder takes
// the distance code that makes the whole nearest. A gradient's z of -64, which no plane has, marks the other kinds:
// bits 7-31 are all set in a coarse cell and are the index of its record of four planes (words as above) in a crease
// cell. The last bit of the distance of the record's first two words defines how the planes combine: with u_k = side *
// plane_k,
//   distance = side * max(A, B), A of u_0 and u_1, B of u_2 and u_3,
// side = -1 if the first has it set; A and B are the smaller of their two if the second has it set, else the larger.
enum class CellKind : std::uint32_t {
  kPlane = 0,
  kCrease = 1,
  kCoarse = 2,  // farther than the band: the coarse grid holds it
};
constexpr std::uint32_t kOtherKind = 0x40;  // in bits 0-6
constexpr std::uint32_t kCoarseWord = 0xffffff80U | kOtherKind;
constexpr std::uint32_t kMaxCreases = 0x1ffffffU;  // records of a field
constexpr std::uint32_t kCombineBit = 1U << 21;

constexpr std::uint32_t kPlanesPerCrease = 4;
constexpr float kDistanceSteps = 256.0f;  // per voxel
constexpr float kLargestWordDistance = 1023.0f / kDistanceSteps;
constexpr float kGradientSteps = 63.0f;
// Of a word as an integer: voxels per unit; of a gradient's code in the seven uppermost bits.
constexpr float kWordScale = 0x1p-29f;
constexpr float kGradientScale = 0x1p-25f / kGradientSteps;

inline std::uint32_t EncodePlane(float distance_voxels, const glm::vec3& gradient) {
  const auto code = [](float c) {
    return static_cast<std::uint32_t>(
               static_cast<std::int32_t>(std::rint(std::clamp(c, -1.0f, 1.0f) * kGradientSteps))) &
           0x7fU;
  };
  const std::uint32_t low = code(gradient.x) << 14 | code(gradient.y) << 7 | code(gradient.z);
  const double steps = static_cast<double>(distance_voxels) * static_cast<double>(kDistanceSteps) -
                       static_cast<double>(low) / static_cast<double>(kCombineBit);
  const auto distance = static_cast<std::int32_t>(std::rint(std::clamp(steps, -1024.0, 1023.0)));
  return static_cast<std::uint32_t>(distance) << 21 | low;
}
inline std::uint32_t CreaseWord(std::size_t record) {
  return static_cast<std::uint32_t>(record) << 7 | kOtherKind;
}
inline std::uint32_t RecordOf(std::uint32_t crease_word) {
  return crease_word >> 7;
}
// The word with the last bit of its distance set or cleared: where it has to change, by 1/256 voxel up or down. The
// gradient's last bits decide which, equally often, so that a surface of many such words is not biased.
inline std::uint32_t WithCombineBit(std::uint32_t word, bool is_set) {
  if (((word & kCombineBit) != 0) == is_set) return word;
  return ((word ^ word >> 7 ^ word >> 14) & 1U) != 0 ? word + kCombineBit : word - kCombineBit;
}

// The plane moved by so many 1/256 voxel; its distance must not leave the range.
inline std::uint32_t WithLift(std::uint32_t word, int steps) {
  return word + (static_cast<std::uint32_t>(steps) << 21);
}

inline CellKind KindOf(std::uint32_t word) {
  if ((word & 0x7fU) != kOtherKind) return CellKind::kPlane;
  return word == kCoarseWord ? CellKind::kCoarse : CellKind::kCrease;
}
inline float DistanceOf(std::uint32_t word) {
  return static_cast<float>(static_cast<std::int32_t>(word)) * kWordScale;
}
// About a unit vector: what the distance changes by per voxel.
inline glm::vec3 GradientOf(std::uint32_t word) {
  const auto decode = [](std::uint32_t top) {
    return static_cast<float>(static_cast<std::int32_t>(top & 0xfe000000U)) * kGradientScale;
  };
  return {decode(word << 11), decode(word << 18), decode(word << 25)};
}

// Gradients of the coarse grid: x, y, z in bits 0-7, 8-15, 16-23, two's complement, 1/127.
constexpr float kCoarseGradientSteps = 127.0f;
constexpr float kCoarseGradientScale = 0x1p-24f / kCoarseGradientSteps;  // of a code in the eight uppermost bits

inline std::uint32_t EncodeCoarseGradient(const glm::vec3& gradient) {
  const auto code = [](float c) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(c, -1.0f, 1.0f) * kCoarseGradientSteps)) & 0xffU;
  };
  return code(gradient.x) | code(gradient.y) << 8 | code(gradient.z) << 16;
}
inline glm::vec3 CoarseGradientOf(std::uint32_t code) {
  const auto decode = [](std::uint32_t top) {
    return static_cast<float>(static_cast<std::int32_t>(top & 0xff000000U)) * kCoarseGradientScale;
  };
  return {decode(code << 24), decode(code << 16), decode(code << 8)};
}

}  // namespace vps
