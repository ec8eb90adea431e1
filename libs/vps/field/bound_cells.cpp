#include "vps/field/bound_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "vps/field/voxel_falls.hpp"
#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
// Rounding of the walk's floats, voxels: four times 2^-24 of a coordinate of 8,000 voxels. Not derived more closely.
constexpr float kRounding = 2e-3f;

struct Plane {
  float distance;
  glm::vec3 gradient;
  glm::vec3 centre;
};

constexpr int kTile = 8;  // words of half a tile of WordInBrick: 4 x 2 voxels
using Lanes = float __attribute__((vector_size(kTile * sizeof(float))));
using Words = std::uint32_t __attribute__((vector_size(kTile * sizeof(std::uint32_t))));
using Ints = std::int32_t __attribute__((vector_size(kTile * sizeof(std::int32_t))));

// Largest value of `plane` minus a voxel's own plane, over eight voxels; `begin`: lower corner of the first. Of two
// planes a and b over a box |p - c| <= h it is  a(c) - b(c) + |g_a - g_b| . h,  g their gradients, at one of the
// corners.
[[gnu::always_inline]] inline float MostAboveTile(const Plane& plane, const std::uint32_t* words,
                                                  const glm::vec3& begin) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  constexpr Lanes kX = {0.5f, 1.5f, 2.5f, 3.5f, 0.5f, 1.5f, 2.5f, 3.5f};
  constexpr Lanes kY = {0.5f, 0.5f, 0.5f, 0.5f, 1.5f, 1.5f, 1.5f, 1.5f};
  Words word;
  __builtin_memcpy(&word, words, sizeof word);
  const Lanes d = __builtin_convertvector((Ints)word, Lanes) * kWordScale;
  const Lanes mx = plane.gradient.x - __builtin_convertvector((Ints)(word << 11 & kTop), Lanes) * kGradientScale;
  const Lanes my = plane.gradient.y - __builtin_convertvector((Ints)(word << 18 & kTop), Lanes) * kGradientScale;
  const Lanes mz = plane.gradient.z - __builtin_convertvector((Ints)(word << 25), Lanes) * kGradientScale;
  const Lanes slope = ((mx < 0.0f ? -mx : mx) * 0.5f + (my < 0.0f ? -my : my) * 0.5f) + (mz < 0.0f ? -mz : mz) * 0.5f;
  const Lanes at_centre =
      plane.distance +
      ((plane.gradient.x * (kX + begin.x - plane.centre.x) + plane.gradient.y * (kY + begin.y - plane.centre.y)) +
       plane.gradient.z * (0.5f + begin.z - plane.centre.z));
  const Lanes here = at_centre - d + slope;
  const Lanes most = (word & 0x7fU) != kOtherKind ? here : Lanes{};
  float largest = 0.0f;
  for (int i = 0; i < kTile; ++i) largest = std::max(largest, most[i]);
  return largest;
}

// The same for the creases among them.
[[gnu::always_inline]] inline float MostAboveCreases(const Plane& plane, const DistanceField& field,
                                                     const std::uint32_t* words, const glm::vec3& begin) {
  float largest = 0.0f;
  for (int i = 0; i < kTile; ++i) {
    if (KindOf(words[i]) != CellKind::kCrease) continue;
    const glm::vec3 centre = begin + glm::vec3(i & 3, i >> 2, 0) + 0.5f;
    const float d = plane.distance + glm::dot(plane.gradient, centre - plane.centre);
    largest = std::max(largest,
                       MostAboveCrease(field, RecordOf(words[i]), d, plane.gradient, glm::vec3(0.0f), glm::vec3(0.5f)));
  }
  return largest;
}

// Largest value of `plane` minus the field over a cube of `step` voxels in a brick; `begin`: its first voxel.
VPS_WIDE_CLONES float MostAboveBrick(const Plane& plane, const DistanceField& field, const std::uint32_t* words,
                                     const glm::ivec3& begin, int step) {
  float largest = 0.0f;
  for (int z = begin.z; z < begin.z + step; ++z) {
    for (int y = begin.y; y < begin.y + step; y += 2) {
      for (int x = begin.x; x < begin.x + step; x += 4) {
        const std::uint32_t* const tile = words + WordInBrick(x, y, z);
        largest = std::max(largest, MostAboveTile(plane, tile, glm::vec3(x, y, z)));
        largest = std::max(largest, MostAboveCreases(plane, field, tile, glm::vec3(x, y, z)));
      }
    }
  }
  return largest;
}

class Bounds {
 public:
  explicit Bounds(const DistanceField& field)
      : field_(field),
        n_(field.nx >> field.coarse_shift, field.ny >> field.coarse_shift, field.nz >> field.coarse_shift),
        side_(1 << field.coarse_shift),
        fall_(field.coarse.size(), kNone),
        voxel_falls_(field.coarse.size(), kNone) {}

  std::vector<CoarseCell> Find(core::ParallelFor* workers, const std::function<void()>& beside) {
    const auto num_layers = static_cast<std::size_t>(n_.z);
    core::ForEach(workers, 1 + num_layers, [&](std::size_t i) {
      if (i == 0) {
        beside();
      } else {
        FindFalls(static_cast<int>(i - 1));
      }
    });
    std::vector<CoarseCell> bounded = field_.coarse;
    core::ForEach(workers, num_layers, [&](std::size_t z) { Bound(static_cast<int>(z), &bounded); });
    return bounded;
  }

 private:
  // Of the cells with the same z.
  void FindFalls(int z) {
    // Farther cells are culled by the distance at their centre alone.
    const float near = DistanceField::kBandVoxels + 2.0f * static_cast<float>(side_);
    ForCells(z, [&](const glm::ivec3& c, std::size_t i) {
      if (std::abs(field_.coarse[i].distance) < near) fall_[i] = OwnFall(c);
    });
    FindVoxelFalls(field_, z, &voxel_falls_[Index({0, 0, z})]);
  }
  void Bound(int z, std::vector<CoarseCell>* bounded) const {
    ForCells(z, [&](const glm::ivec3& c, std::size_t i) {
      const std::uint32_t wide = fall_[i] == kNone ? 0 : Code(FallWithin(c, kWideMargin));
      CoarseCell& cell = (*bounded)[i];
      const auto bits = std::bit_cast<std::uint32_t>(cell.distance);
      cell.distance = std::bit_cast<float>((bits & 0xffffff00U) | wide);
      cell.gradient = (cell.gradient & 0xffffffU) | Code(voxel_falls_[i]) << 24;
    });
  }

  template <class Visit>
  void ForCells(int z, const Visit& visit) const {
    std::size_t i = Index({0, 0, z});
    for (int y = 0; y < n_.y; ++y) {
      for (int x = 0; x < n_.x; ++x) visit({x, y, z}, i++);
    }
  }
  [[nodiscard]] std::size_t Index(const glm::ivec3& c) const {
    return (static_cast<std::size_t>(c.z) * n_.y + c.y) * n_.x + c.x;
  }
  [[nodiscard]] Plane PlaneOf(const glm::ivec3& c) const {
    const CoarseCell& cell = field_.coarse[Index(c)];
    return {cell.distance, CoarseGradientOf(cell.gradient), (glm::vec3(c) + 0.5f) * static_cast<float>(side_)};
  }

  // Largest of plane a - plane b over the box |p - centre| <= half.
  static float MostAbove(const Plane& a, const Plane& b, const glm::vec3& centre, const glm::vec3& half) {
    const glm::vec3 slope = glm::abs(a.gradient - b.gradient);
    return a.distance + glm::dot(a.gradient, centre - a.centre) - b.distance - glm::dot(b.gradient, centre - b.centre) +
           glm::dot(slope, half);
  }
  // How far the field of cell c falls below its plane within the cell.
  [[nodiscard]] float OwnFall(const glm::ivec3& c) const {
    const Plane plane = PlaneOf(c);
    const glm::ivec3 begin = c * side_;
    const int step = std::min(side_, DistanceField::kBrick);
    float fall = 0.0f;
    for (int z = begin.z; z < begin.z + side_; z += step) {
      for (int y = begin.y; y < begin.y + side_; y += step) {
        for (int x = begin.x; x < begin.x + side_; x += step) {
          const std::uint32_t brick = field_.bricks[(static_cast<std::size_t>(z >> 3) * (field_.ny >> 3) + (y >> 3)) *
                                                        static_cast<std::size_t>(field_.nx >> 3) +
                                                    static_cast<std::size_t>(x >> 3)];
          if (brick == 0) continue;  // nothing but coarse cells
          fall = std::max(fall, MostAboveBrick(plane, field_, &field_.words[brick], {x, y, z}, step));
        }
      }
    }
    return fall;
  }
  // The same within `margin` of the cell. In a neighbour n the field is at least its plane b less its own fall, so
  //   a - field <= max over the shared box of (a - b) + fall(n).
  [[nodiscard]] float FallWithin(const glm::ivec3& c, float margin) const {
    const Plane plane = PlaneOf(c);
    const float half = 0.5f * static_cast<float>(side_);
    float fall = fall_[Index(c)];
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const glm::ivec3 other = c + step;
      if (step == glm::ivec3(0) || glm::any(glm::lessThan(other, glm::ivec3(0))) ||
          glm::any(glm::greaterThanEqual(other, n_))) {
        continue;
      }
      // The box shared by the grown cell and the neighbour.
      const glm::vec3 along(glm::abs(step));
      const glm::vec3 centre = plane.centre + glm::vec3(step) * (half + 0.5f * margin);
      const glm::vec3 extent = half * (1.0f - along) + 0.5f * margin * along;
      fall = std::max(fall, MostAbove(plane, PlaneOf(other), centre, extent) + fall_[Index(other)]);
    }
    return fall;
  }

  static std::uint32_t Code(float fall) {
    const float code = std::ceil((fall + kRounding) * kFallSteps) + 1.0f;
    return code <= 255.0f ? static_cast<std::uint32_t>(code) : 0;
  }

  const DistanceField& field_;
  glm::ivec3 n_;
  int side_;
  std::vector<float> fall_;
  std::vector<float> voxel_falls_;
};

}  // namespace

std::vector<CoarseCell> BoundCells(const DistanceField& field, core::ParallelFor* workers,
                                   const std::function<void()>& beside) {
  return Bounds(field).Find(workers, beside);
}

}  // namespace vps
