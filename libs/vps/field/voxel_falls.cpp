#include "vps/field/voxel_falls.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr int kMostSide = 8;  // of a coarse cell
constexpr int kWidth = kMostSide + 2;

// Of a word: its gradient. Beyond that: none yet, more than one.
constexpr std::uint32_t kDirectionBits = 0x1fffffU;
constexpr std::uint32_t kNoDirection = 0x200000U;
constexpr std::uint32_t kManyDirections = 0x400000U;

// A coarse cell's voxels and those around them: [(z * kWidth + y) * kWidth + x], and a row to spare for whole vectors.
constexpr int kNumVoxels = kWidth * kWidth * kWidth;
constexpr int kNumKept = (kNumVoxels + 2 * kMostSide - 1) / kMostSide * kMostSide;
using Lanes = float __attribute__((vector_size(kMostSide * sizeof(float))));
using Words = std::uint32_t __attribute__((vector_size(kMostSide * sizeof(std::uint32_t))));
using Ints = std::int32_t __attribute__((vector_size(kMostSide * sizeof(std::int32_t))));

struct Voxels {
  std::uint32_t word[kNumKept] = {};
  float d[kNumKept] = {};  // of planes, at their centres
  float gx[kNumKept] = {}, gy[kNumKept] = {}, gz[kNumKept] = {};
};

template <class Vector, class Element>
[[gnu::always_inline]] inline void Load(const Element* from, Vector* to) {
  __builtin_memcpy(to, from, sizeof(Vector));
}
[[gnu::always_inline]] inline void Store(const Lanes& from, float* to) {
  __builtin_memcpy(to, &from, sizeof(Lanes));
}

// A voxel's neighbour: of its box only what lies within kCloseRadius of the voxel.
struct Neighbour {
  int x, y, z;
  glm::vec3 centre;  // of that part, from the voxel's centre
  glm::vec3 half;
};

std::array<Neighbour, 27> MakeNeighbours() {
  std::array<Neighbour, 27> all;
  for (int i = 0; i < 27; ++i) {
    const glm::ivec3 o(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const glm::vec3 along(glm::abs(o));
    all[static_cast<std::size_t>(i)] = {o.x, o.y, o.z, glm::vec3(o) * (0.5f + 0.5f * kCloseRadius),
                                        0.5f * (1.0f - along) + 0.5f * kCloseRadius * along};
  }
  return all;
}

const std::array<Neighbour, 27> kNeighbours = MakeNeighbours();

[[gnu::always_inline]] inline void Decode(Voxels* voxels) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  for (int i = 0; i < kNumKept; i += kMostSide) {
    Words word;
    Load(voxels->word + i, &word);
    Store(__builtin_convertvector((Ints)word, Lanes) * kWordScale, voxels->d + i);
    Store(__builtin_convertvector((Ints)(word << 11 & kTop), Lanes) * kGradientScale, voxels->gx + i);
    Store(__builtin_convertvector((Ints)(word << 18 & kTop), Lanes) * kGradientScale, voxels->gy + i);
    Store(__builtin_convertvector((Ints)(word << 25), Lanes) * kGradientScale, voxels->gz + i);
  }
}

// Of the voxels `at` ... `at` + 7, where they are planes and their neighbour is one, how far that lies below them.
[[gnu::always_inline]] inline void FallBeside(const Voxels& voxels, int at, const Neighbour& n, Lanes* fall) {
  const int other = at + (n.z * kWidth + n.y) * kWidth + n.x;
  Lanes d, gx, gy, gz, ud, ux, uy, uz;
  Load(voxels.d + at, &d);
  Load(voxels.gx + at, &gx);
  Load(voxels.gy + at, &gy);
  Load(voxels.gz + at, &gz);
  Load(voxels.d + other, &ud);
  Load(voxels.gx + other, &ux);
  Load(voxels.gy + other, &uy);
  Load(voxels.gz + other, &uz);
  Words word;
  Load(voxels.word + other, &word);
  const glm::vec3 from = n.centre - glm::vec3(n.x, n.y, n.z);
  const Lanes mx = gx - ux;
  const Lanes my = gy - uy;
  const Lanes mz = gz - uz;
  const Lanes most =
      ((mx < 0.0f ? -mx : mx) * n.half.x + (my < 0.0f ? -my : my) * n.half.y) + (mz < 0.0f ? -mz : mz) * n.half.z;
  const Lanes here = d - ud + ((gx * n.centre.x + gy * n.centre.y) + gz * n.centre.z) -
                     ((ux * from.x + uy * from.y) + uz * from.z) + most;
  const Lanes known = (word & 0x7fU) != kOtherKind ? here : Lanes{};
  *fall = known > *fall ? known : *fall;
}

// The close bound of a coarse cell of `side` voxels whose planes have more than one gradient.
VPS_WIDE_CLONES float LargestFall(const DistanceField& field, int side, Voxels* voxels) {
  Decode(voxels);
  float largest = -1.0f;
  for (int z = 1; z <= side; ++z) {
    for (int y = 1; y <= side; ++y) {
      const int at = (z * kWidth + y) * kWidth + 1;
      unsigned anchors = 0;
      for (int x = 0; x < side; ++x) {
        const bool is_anchor =
            KindOf(voxels->word[at + x]) == CellKind::kPlane && std::abs(voxels->d[at + x]) <= kMostAnchorDistance;
        anchors |= (is_anchor ? 1U : 0U) << x;
      }
      if (anchors == 0) continue;
      Lanes falls{};
      for (const Neighbour& n : kNeighbours) {
        FallBeside(*voxels, at, n, &falls);
        const int other = at + (n.z * kWidth + n.y) * kWidth + n.x;
        for (unsigned left = anchors; left != 0; left &= left - 1) {
          const int x = std::countr_zero(left);
          const std::uint32_t word = voxels->word[other + x];
          if ((word & 0x7fU) != kOtherKind) continue;
          if (word == kCoarseWord) return kNone;
          const glm::vec3 g(voxels->gx[at + x], voxels->gy[at + x], voxels->gz[at + x]);
          largest = std::max(largest, MostAboveCrease(field, RecordOf(word), voxels->d[at + x] + glm::dot(g, n.centre),
                                                      g, n.centre - glm::vec3(n.x, n.y, n.z), n.half));
        }
      }
      for (unsigned left = anchors; left != 0; left &= left - 1)
        largest = std::max(largest, falls[std::countr_zero(left)]);
    }
  }
  return largest < 0.0f ? kNone : largest;
}

class VoxelFalls {
 public:
  explicit VoxelFalls(const DistanceField& field) : field_(field), side_(1 << field.coarse_shift) {}

  float Of(const glm::ivec3& cell) {
    if (side_ > kMostSide) return kNone;
    const glm::ivec3 begin = cell * side_ - 1;
    if (glm::any(glm::lessThan(begin, glm::ivec3(0))) ||
        glm::any(glm::greaterThan(begin + side_ + 2, glm::ivec3(field_.nx, field_.ny, field_.nz)))) {
      return kNone;
    }
    Read(begin);
    if (direction_ < kNoDirection) return SpreadOfOffsets();
    return LargestFall(field_, side_, &voxels_);
  }

 private:
  void Read(const glm::ivec3& begin) {
    direction_ = kNoDirection;
    for (int z = 0; z < side_ + 2; ++z) {
      for (int y = 0; y < side_ + 2; ++y) {
        const glm::ivec3 v = begin + glm::ivec3(0, y, z);
        const std::uint32_t* const bricks =
            &field_.bricks[(static_cast<std::size_t>(v.z >> 3) * static_cast<std::size_t>(field_.ny >> 3) +
                            static_cast<std::size_t>(v.y >> 3)) *
                           static_cast<std::size_t>(field_.nx >> 3)];
        std::uint32_t* const row = voxels_.word + (z * kWidth + y) * kWidth;
        for (int x = 0; x < side_ + 2; ++x) {
          const int vx = v.x + x;
          row[x] = field_.words[bricks[vx >> 3] + WordInBrick(vx, v.y, v.z)];
          if (row[x] == kCoarseWord) continue;
          const bool is_plane = KindOf(row[x]) == CellKind::kPlane;
          if (direction_ == kNoDirection && is_plane) direction_ = row[x] & kDirectionBits;
          if (!is_plane || (row[x] & kDirectionBits) != direction_) direction_ = kManyDirections;
        }
      }
    }
  }

  // Where all planes have one gradient g, one lies above another by e - e', e = d - g . centre: on flat faces the
  // spread of e is all that has to be known. Coarse voxels do not count: none is beside an anchor, which is at most
  // kMostAnchorDistance from the surface and its neighbours so nearer than kBandVoxels.
  [[nodiscard]] float SpreadOfOffsets() const {
    const glm::vec3 g = GradientOf(direction_);
    float largest = -kNone;
    float smallest = kNone;
    for (int z = 0; z < side_ + 2; ++z) {
      for (int y = 0; y < side_ + 2; ++y) {
        for (int x = 0; x < side_ + 2; ++x) {
          const std::uint32_t word = voxels_.word[(z * kWidth + y) * kWidth + x];
          if (word == kCoarseWord) continue;
          const float offset = DistanceOf(word) - glm::dot(g, glm::vec3(x, y, z));
          largest = std::max(largest, offset);
          smallest = std::min(smallest, offset);
        }
      }
    }
    return largest - smallest;
  }

  const DistanceField& field_;
  int side_;
  std::uint32_t direction_ = kNoDirection;  // of all planes, or kNoDirection, kManyDirections
  Voxels voxels_;
};

}  // namespace

float MostAboveCrease(const DistanceField& field, std::uint32_t record, float d, const glm::vec3& gradient,
                      const glm::vec3& offset, const glm::vec3& half) {
  const std::uint32_t* const planes = &field.creases[std::size_t{record} * kPlanesPerCrease];
  float u[kPlanesPerCrease];
  for (std::uint32_t k = 0; k < kPlanesPerCrease; ++k) {
    const glm::vec3 g = GradientOf(planes[k]);
    u[k] = d - DistanceOf(planes[k]) - glm::dot(g, offset) + glm::dot(glm::abs(gradient - g), half);
  }
  const bool is_flipped = (planes[0] & kCombineBit) != 0;
  const bool is_nested = (planes[1] & kCombineBit) != 0;
  // The larger of two planes is below the plane by the smaller of the two differences, and the other way round.
  const auto pair = [&](float p, float q) { return is_nested != is_flipped ? std::max(p, q) : std::min(p, q); };
  const float A = pair(u[0], u[1]);
  const float B = pair(u[2], u[3]);
  return is_flipped ? std::max(A, B) : std::min(A, B);
}

void FindVoxelFalls(const DistanceField& field, int z, float* falls) {
  const glm::ivec3 n(field.nx >> field.coarse_shift, field.ny >> field.coarse_shift, field.nz >> field.coarse_shift);
  // A cell's centre cannot be farther from the surface than an anchor in it and half the cell's diagonal.
  const float near = kMostAnchorDistance + 0.5f + 0.8661f * static_cast<float>(1 << field.coarse_shift);
  VoxelFalls of(field);
  std::size_t i = static_cast<std::size_t>(z) * static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y);
  for (int y = 0; y < n.y; ++y) {
    for (int x = 0; x < n.x; ++x, ++i) {
      *falls++ = std::abs(field.coarse[i].distance) <= near ? of.Of({x, y, z}) : kNone;
    }
  }
}

}  // namespace vps
