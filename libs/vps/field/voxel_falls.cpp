#include "vps/field/voxel_falls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vps {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr int kMostSide = 8;  // of a coarse cell
constexpr int kWidth = kMostSide + 2;

// Of a word: its gradient. Beyond that: none yet, more than one.
constexpr std::uint32_t kDirectionBits = 0x1fffffU;
constexpr std::uint32_t kNoDirection = 0x200000U;
constexpr std::uint32_t kManyDirections = 0x400000U;

constexpr std::int32_t kPlane = -1;
constexpr std::int32_t kCoarse = -2;

struct Voxel {
  float d = 0.0f;  // at its centre
  glm::vec3 g{0.0f};
  std::int32_t record = kPlane;  // of a crease
};

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
    if (largest_offset_ >= smallest_offset_) return largest_offset_ - smallest_offset_;
    float fall = -1.0f;
    for (int z = 1; z <= side_; ++z) {
      for (int y = 1; y <= side_; ++y) {
        for (int x = 1; x <= side_; ++x) {
          const int at = (z * kWidth + y) * kWidth + x;
          const Voxel& v = around_[static_cast<std::size_t>(at)];
          if (v.record == kPlane && std::abs(v.d) <= kMostAnchorDistance) fall = std::max(fall, Beside(v, at));
        }
      }
    }
    return fall < 0.0f ? kNone : fall;
  }

 private:
  // Where all planes have one gradient g, one lies above another by e - e', e = d - g . centre: on flat faces the
  // spread of e is all that has to be known. Coarse voxels do not count: none is beside an anchor, which is at most
  // kMostAnchorDistance from the surface and its neighbours so nearer than kBandVoxels.
  void Read(const glm::ivec3& begin) {
    std::uint32_t direction = kNoDirection;
    largest_offset_ = -kNone;
    smallest_offset_ = kNone;
    for (int z = 0; z < side_ + 2; ++z) {
      for (int y = 0; y < side_ + 2; ++y) {
        for (int x = 0; x < side_ + 2; ++x) {
          const glm::ivec3 v = begin + glm::ivec3(x, y, z);
          const auto brick = (static_cast<std::size_t>(v.z >> 3) * static_cast<std::size_t>(field_.ny >> 3) +
                              static_cast<std::size_t>(v.y >> 3)) *
                                 static_cast<std::size_t>(field_.nx >> 3) +
                             static_cast<std::size_t>(v.x >> 3);
          const std::uint32_t word = field_.words[field_.bricks[brick] + WordInBrick(v.x, v.y, v.z)];
          Voxel& voxel = around_[static_cast<std::size_t>((z * kWidth + y) * kWidth + x)];
          voxel.record = kPlane;
          if (word == kCoarseWord) {
            voxel.record = kCoarse;
          } else if (KindOf(word) == CellKind::kPlane) {
            voxel.d = DistanceOf(word);
            voxel.g = GradientOf(word);
            if (direction == kNoDirection) direction = word & kDirectionBits;
            if ((word & kDirectionBits) != direction) direction = kManyDirections;
            const float offset = voxel.d - glm::dot(voxel.g, glm::vec3(x, y, z));
            largest_offset_ = std::max(largest_offset_, offset);
            smallest_offset_ = std::min(smallest_offset_, offset);
          } else {
            direction = kManyDirections;
            voxel.record = static_cast<std::int32_t>(RecordOf(word));
          }
        }
      }
    }
    if (direction >= kNoDirection) largest_offset_ = -kNone;
  }

  [[nodiscard]] float Beside(const Voxel& v, int at) const {
    float fall = 0.0f;
    for (const Neighbour& n : neighbours_) {
      const Voxel& u = around_[static_cast<std::size_t>(at + (n.z * kWidth + n.y) * kWidth + n.x)];
      const glm::vec3 from(n.x, n.y, n.z);
      if (u.record == kCoarse) return kNone;
      if (u.record >= 0) {
        fall = std::max(fall, MostAboveCrease(field_, static_cast<std::uint32_t>(u.record),
                                              v.d + glm::dot(v.g, n.centre), v.g, n.centre - from, n.half));
        continue;
      }
      fall = std::max(fall, v.d - u.d + glm::dot(v.g, n.centre) - glm::dot(u.g, n.centre - from) +
                                glm::dot(glm::abs(v.g - u.g), n.half));
    }
    return fall;
  }

  const DistanceField& field_;
  int side_;
  std::array<Neighbour, 27> neighbours_ = MakeNeighbours();
  float largest_offset_ = 0.0f, smallest_offset_ = 0.0f;  // of e; the other way round when directions differ
  std::array<Voxel, kWidth * kWidth * kWidth> around_;
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

std::vector<float> FindVoxelFalls(const DistanceField& field, core::ParallelFor* workers) {
  const glm::ivec3 n(field.nx >> field.coarse_shift, field.ny >> field.coarse_shift, field.nz >> field.coarse_shift);
  // A cell's centre cannot be farther from the surface than an anchor in it and half the cell's diagonal.
  const float near = kMostAnchorDistance + 0.5f + 0.8661f * static_cast<float>(1 << field.coarse_shift);
  std::vector<float> all(field.coarse.size(), kNone);
  core::ForEach(workers, static_cast<std::size_t>(n.z), [&](std::size_t z) {
    VoxelFalls falls(field);
    std::size_t i = z * static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y);
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x, ++i) {
        if (std::abs(field.coarse[i].distance) <= near) all[i] = falls.Of({x, y, static_cast<int>(z)});
      }
    }
  });
  return all;
}

}  // namespace vps
