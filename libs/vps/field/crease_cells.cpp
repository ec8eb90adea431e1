#include "vps/field/crease_cells.hpp"

#include <algorithm>
#include <cmath>

#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

// A neighbour's distance may differ from the cell's tangent plane by this times r^2, r the distance of the two centres,
// before the cell is examined as a crease: r^2 / 2R of a radius of curvature R of 6 voxels. Table of decision 6.
constexpr float kCreaseTolerance = 0.08f;
// Farther cells keep their planes: none of their points is within 1.5 voxels of the surface (half a diagonal is 0.87),
// where errors are measured.
constexpr float kFarthest = 1.5f + 0.87f;
constexpr float kNone = 1e30f;

// Cells -1 ... 8 in each direction; rows hold 10 and some to spare.
struct Apron {
  static constexpr int kRow = 12;
  static constexpr int kLayer = 10 * kRow;
  float d[10 * kLayer + 8], gx[10 * kLayer + 8], gy[10 * kLayer + 8], gz[10 * kLayer + 8];

  void Put(int at, std::uint32_t word) {
    d[at] = (word & 0x7fU) == kOtherKind ? kNone : DistanceOf(word);
    const glm::vec3 g = GradientOf(word);
    gx[at] = g.x;
    gy[at] = g.y;
    gz[at] = g.z;
  }
};

using Lanes = float __attribute__((vector_size(8 * sizeof(float))));
using Words = std::uint32_t __attribute__((vector_size(8 * sizeof(std::uint32_t))));
using Ints = std::int32_t __attribute__((vector_size(8 * sizeof(std::int32_t))));

[[gnu::always_inline]] inline void Load(const float* from, Lanes* to) {
  __builtin_memcpy(to, from, sizeof(Lanes));
}
[[gnu::always_inline]] inline void Store(const Lanes& from, float* to) {
  __builtin_memcpy(to, &from, sizeof(Lanes));
}

// Apron::Put of eight words.
[[gnu::always_inline]] inline void PutRow(int at, const std::uint32_t* row, Apron* apron) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  Words words;
  __builtin_memcpy(&words, row, sizeof words);
  const Lanes d = __builtin_convertvector((Ints)words, Lanes) * kWordScale;
  Store((words & 0x7fU) == kOtherKind ? Lanes{} + kNone : d, apron->d + at);
  Store(__builtin_convertvector((Ints)(words << 11 & kTop), Lanes) * kGradientScale, apron->gx + at);
  Store(__builtin_convertvector((Ints)(words << 18 & kTop), Lanes) * kGradientScale, apron->gy + at);
  Store(__builtin_convertvector((Ints)(words << 25), Lanes) * kGradientScale, apron->gz + at);
}

[[gnu::always_inline]] inline void Fill(const Neighbourhood& bricks, Apron* apron) {
  for (int z = -1; z <= 8; ++z) {
    for (int y = -1; y <= 8; ++y) {
      const int at = (z + 1) * Apron::kLayer + (y + 1) * Apron::kRow;
      apron->Put(at, WordAt(bricks, -1, y, z));
      PutRow(at + 1, &WordAt(bricks, 0, y, z), apron);
      apron->Put(at + 9, WordAt(bricks, 8, y, z));
      apron->Put(at + 10, kCoarseWord);
      apron->Put(at + 11, kCoarseWord);
    }
  }
}

// Largest deviation of the distances of all cells in the band from one plane, whose slopes come from the farthest cells
// along each axis from the cell nearest to the surface. Settles nine tenths of a machined part's bricks.
[[gnu::always_inline]] inline float MissOfOnePlane(const Apron& apron) {
  const auto at = [](int x, int y, int z) { return (z + 1) * Apron::kLayer + (y + 1) * Apron::kRow + x + 1; };
  glm::ivec3 middle(0);
  float least = kNone;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const float d = std::abs(apron.d[at(x, y, z)]);
        if (d < least) least = d, middle = {x, y, z};
      }
    }
  }
  if (least == kNone) return kNone;
  const float own = apron.d[at(middle.x, middle.y, middle.z)];
  glm::vec3 slope(0.0f);
  for (int axis = 0; axis < 3; ++axis) {
    int most = 0;
    for (int k = -1; k <= 8; ++k) {
      glm::ivec3 c = middle;
      c[axis] = k;
      const float d = apron.d[at(c.x, c.y, c.z)];
      const int way = k - middle[axis];
      if (d == kNone || std::abs(way) <= std::abs(most)) continue;
      most = way;
      slope[axis] = (d - own) / static_cast<float>(way);
    }
    if (most == 0) return kNone;
  }
  constexpr Lanes kX = {0, 1, 2, 3, 4, 5, 6, 7};
  Lanes most{};
  for (int z = -1; z <= 8; ++z) {
    for (int y = -1; y <= 8; ++y) {
      for (int x = -1; x <= 1; x += 2) {
        Lanes d;
        Load(apron.d + at(x, y, z), &d);
        const Lanes miss =
            d - (own + slope.x * (kX + static_cast<float>(x - middle.x)) + slope.y * static_cast<float>(y - middle.y) +
                 slope.z * static_cast<float>(z - middle.z));
        Lanes size = miss < 0.0f ? -miss : miss;
        size = d < kNone ? size : Lanes{};
        most = size > most ? size : most;
      }
    }
  }
  float largest = 0.0f;
  for (int i = 0; i < 8; ++i) largest = std::max(largest, most[i]);
  return largest;
}

// How far the planes of a row of cells miss the distances at the offset (x, y, z), less the tolerance; 0 where there
// are none.
[[gnu::always_inline]] inline void AddExcess(const Apron& apron, int at, int x, int y, int z, Lanes* excess) {
  const int other = at + z * Apron::kLayer + y * Apron::kRow + x;
  const float tolerance = kCreaseTolerance * static_cast<float>(x * x + y * y + z * z);
  Lanes own, next, gx, gy, gz;
  Load(apron.d + at, &own);
  Load(apron.d + other, &next);
  Load(apron.gx + at, &gx);
  Load(apron.gy + at, &gy);
  Load(apron.gz + at, &gz);
  const Lanes planned = own + gx * static_cast<float>(x) + gy * static_cast<float>(y) + gz * static_cast<float>(z);
  const Lanes miss = next - planned;
  Lanes size = miss < 0.0f ? -miss : miss;
  size = next < kNone ? size - tolerance : Lanes{};
  *excess = size > *excess ? size : *excess;
}

// Dither in [0, 1), evenly spread over the cells of any surface (the additive sequence of Roberts 2018 in three
// dimensions): lifts of less than a step are right in the mean.
inline float Threshold(int x, int y, int z) {
  const float sum =
      0.8191725f * static_cast<float>(x) + 0.6710436f * static_cast<float>(y) + 0.5497005f * static_cast<float>(z);
  return sum - std::floor(sum);
}

// Of a row of cells, voxels; 0 where a neighbour is not known.
[[gnu::always_inline]] inline void FindLifts(const Apron& apron, int at, Lanes* lifts) {
  constexpr std::array<int, 3> kSteps{1, Apron::kRow, Apron::kLayer};
  Lanes own;
  Load(apron.d + at, &own);
  Lanes sum{};
  Lanes largest{};
  for (const int step : kSteps) {
    Lanes before, behind;
    Load(apron.d + at - step, &before);
    Load(apron.d + at + step, &behind);
    sum += before + behind - 2.0f * own;
    largest = before > largest ? before : largest;
    largest = behind > largest ? behind : largest;
  }
  *lifts = largest < kNone ? sum * (1.0f / 24.0f) : Lanes{};
}

}  // namespace

VPS_WIDE_CLONES ExaminedCells ExamineCells(const Neighbourhood& bricks) {
  Apron apron;
  Fill(bricks, &apron);
  ExaminedCells out;
  // Planes within a quarter of the tolerance of one miss their neighbours by less than it.
  if (MissOfOnePlane(apron) < 0.25f * kCreaseTolerance) return out;
  for (int row = 0; row < 64; ++row) {
    const int at = ((row >> 3) + 1) * Apron::kLayer + ((row & 7) + 1) * Apron::kRow + 1;
    unsigned near = 0;
    for (int i = 0; i < 8; ++i) near |= (std::abs(apron.d[at + i]) <= kFarthest ? 1U : 0U) << i;
    if (near == 0) continue;
    Lanes excess{};  // of the plane's error over the tolerance
    for (int k = 0; k < 27; ++k) {
      if (k != 13) AddExcess(apron, at, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1, &excess);
    }
    unsigned creases = near;
    for (int i = 0; i < 8; ++i) {
      if (!(excess[i] > 0.0f)) creases &= ~(1U << i);
    }
    out.creases[static_cast<std::size_t>(row)] = static_cast<std::uint8_t>(creases);
    Lanes lifts;
    FindLifts(apron, at, &lifts);
    for (int i = 0; i < 8; ++i) {
      if (((near & ~creases) >> i & 1U) == 0) continue;
      const float steps = std::clamp(lifts[i] * kDistanceSteps, -127.0f, 126.0f);
      out.lifts[static_cast<std::size_t>(row * 8 + i)] =
          static_cast<std::int8_t>(std::floor(steps + Threshold(i, row & 7, row >> 3)));
    }
  }
  return out;
}

}  // namespace vps
