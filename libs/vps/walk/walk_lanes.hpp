// Body of the walk kernels, included by one file per instruction set, which defines before, inside namespace vps and
// an anonymous namespace: kLanes (4, 8 or 16), the vector types F, I, U of so many float, int32, uint32, and
//   U Gather(const std::uint32_t* base, U index);   F Sqrt(F);   unsigned Bits(I mask);   unsigned LessBits(F a, F b);
//   F Fma(F a, F b, F c);                              a b + c, rounded once
//   Compress(std::uint32_t* to, U v, unsigned mask);   the masked lanes, one after the other; may write a whole U
// Vectors are GCC's: arithmetic and ?: work lane by lane, a comparison gives 0 or -1 per lane.

constexpr int kParts = kBlock / kLanes;  // registers per block

inline F LoadF(const float* p) {
  F v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline U LoadU(const std::uint32_t* p) {
  U v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void StoreF(float* p, F v) {
  __builtin_memcpy(p, &v, sizeof v);
}
inline void StoreU(std::uint32_t* p, U v) {
  __builtin_memcpy(p, &v, sizeof v);
}
inline F Fill(float a) {
  return a - F{};
}
inline F ToF(I v) {
  return __builtin_convertvector(v, F);
}
inline I ToI(F v) {
  return __builtin_convertvector(v, I);
}
inline F Min(F a, F b) {
  return a < b ? a : b;
}
inline F Max(F a, F b) {
  return a > b ? a : b;
}
inline F Abs(F a) {
  return (F)((I)a & 0x7fffffff);
}

inline U LaneNumbers() {
  U v;
  for (int k = 0; k < kLanes; ++k) v[k] = static_cast<std::uint32_t>(k);
  return v;
}

struct Vec3 {
  F x, y, z;
};
inline void Store(const Vec3& v, float* x, float* y, float* z) {
  StoreF(x, v.x);
  StoreF(y, v.y);
  StoreF(z, v.z);
}

inline Vec3 ToVoxels(const WalkInput& in, F x, F y, F z) {
  return {Fma(Fill(in.m[0][0]), x, Fma(Fill(in.m[0][1]), y, Fma(Fill(in.m[0][2]), z, Fill(in.t[0])))),
          Fma(Fill(in.m[1][0]), x, Fma(Fill(in.m[1][1]), y, Fma(Fill(in.m[1][2]), z, Fill(in.t[1])))),
          Fma(Fill(in.m[2][0]), x, Fma(Fill(in.m[2][1]), y, Fma(Fill(in.m[2][2]), z, Fill(in.t[2]))))};
}
inline Vec3 Turn(const WalkInput& in, F x, F y, F z) {
  return {Fma(Fill(in.m[0][0]), x, Fma(Fill(in.m[0][1]), y, in.m[0][2] * z)),
          Fma(Fill(in.m[1][0]), x, Fma(Fill(in.m[1][1]), y, in.m[1][2] * z)),
          Fma(Fill(in.m[2][0]), x, Fma(Fill(in.m[2][1]), y, in.m[2][2] * z))};
}
inline F Dot(const Vec3& a, const Vec3& b) {
  return Fma(a.x, b.x, Fma(a.y, b.y, a.z * b.z));
}
inline F Length(const Vec3& a) {
  return Sqrt(Dot(a, a));
}

inline float Least(F v) {
  typedef float Quarter __attribute__((vector_size(16)));
  Quarter quads[kLanes / 4];
  __builtin_memcpy(quads, &v, sizeof quads);
  for (int count = kLanes / 8; count > 0; count /= 2) {
    for (int k = 0; k < count; ++k) quads[k] = quads[k + count] < quads[k] ? quads[k + count] : quads[k];
  }
  const float a = quads[0][1] < quads[0][0] ? quads[0][1] : quads[0][0];
  const float b = quads[0][3] < quads[0][2] ? quads[0][3] : quads[0][2];
  return b < a ? b : a;
}

#include "vps/walk/field_lanes.hpp"

// How far the points of a sphere's slab can lie below its centre in the plane with gradient g: the slab reaches r
// across its unit normal n and h along it, so they lie lower by at most  r |g - (g . n) n| + h |g . n|.
inline F FindSink(const WalkInput& in, const SphereBlock& block, int at, const Vec3& g) {
  const Vec3 n = Turn(in, LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at));
  const F across = Abs(Dot(g, n) * in.m_per_voxel);  // n is turned and scaled by voxels_per_m
  const F along = Sqrt(Max(Dot(g, g) - across * across, F{}) + 1e-5f);
  return Fma(LoadF(block.r + at), along, LoadF(block.h + at) * across) * in.voxels_per_m;
}

// Lower bounds of the field in spheres, the largest of three: by the distance at the coarse cell's centre, less
// kCullSlack; by that cell's plane and its wide bound; by the plane of the voxel that the centre is in and the close
// bound (CoarseCell). Outside the grid, which is convex, the angle at the grid's nearest place q between p and any
// place of the surface is not acute: the distance is |p - q| and that of q, as the sides of a right angle.
inline F BoundSpheres(const WalkInput& in, const SphereBlock& block, int at) {
  const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
  const F r = LoadF(block.r + at) * in.voxels_per_m;
  const Vec3 q = ClampToGrid(in, p);
  const Coarse cell = ReadCoarse(in, q, ~I{});
  const Vec3 out{p.x - q.x, p.y - q.y, p.z - q.z};
  const F outside = Dot(out, out);
  const F inside = cell.distance - Length(cell.e);
  const F at_least = Max(inside, F{});
  F bound = (outside > 0.0f ? Sqrt(Fma(at_least, at_least, outside)) : inside) - r - kCullSlack;
  const auto take = [&](F plane, I fall, const Vec3& g, I holds) {
    const F least = plane - ToF(fall - 1) * (1.0f / kFallSteps) - FindSink(in, block, at, g);
    bound = holds & (I)(fall != 0) ? Max(bound, least) : bound;
  };
  const I is_narrow = r <= kWideMargin;
  if (Bits(is_narrow) != 0) take(cell.distance + Dot(cell.g, cell.e), cell.wide, cell.g, is_narrow);
  const I is_small = (r <= kCloseRadius) & (bound <= in.margin);
  if (Bits(is_small) != 0) {
    const Voxel voxel = FindVoxel(in, q);
    const U word = ReadWord(in, voxel);
    Vec3 g;
    const F plane = PlaneAndGradient(word, voxel.e, &g);
    take(plane, cell.close, g,
         is_small & (I)((word & 0x7fU) != kOtherKind) & (Abs(WordDistance(word)) <= kMostAnchorDistance));
  }
  return bound;
}

float Bound(const WalkInput& in, std::uint32_t block, float* bounds) {
  const SphereBlock& spheres = in.spheres[block];
  F least = Fill(__builtin_inff());
  for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
    const I is_sphere = LoadF(spheres.x + at) < SampleTree::kFarAway_m;
    const F bound = is_sphere ? BoundSpheres(in, spheres, at) : Fill(__builtin_inff());
    StoreF(bounds + at, bound);
    least = Min(least, bound);
  }
  return Least(least);
}

// Estimate of the least distance of the points of spheres of level 0: the field at the centre, less the depth of the
// slab towards the surface there.
inline F EstimateLeaves(const WalkInput& in, const SphereBlock& block, int at) {
  const FieldAt field =
      SampleWithGradient(in, ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at)));
  return field.distance - FindSink(in, block, at, field.gradient);
}

void Cull(const WalkInput& in, WalkCull* cull) {
  constexpr std::uint32_t kMostLeap = 4;  // blocks of spheres; not derived
  std::uint32_t* queue = cull->queue;
  std::uint32_t* next = cull->queue + cull->queue_half;
  std::uint32_t size = 1;
  queue[0] = 0;
  F free_distance = Fill(1e30f);
  cull->spheres_tested = 0;
  for (std::uint32_t level = in.num_levels; level-- > 0;) {
    std::uint32_t num_next = 0;
    // Where everything survives, in deep or conforming contact, testing spheres only costs: after a block of leaves
    // without loss the next one is taken as it is, then the next three. The last one may have fillers.
    std::uint32_t leap = 1;
    std::uint32_t num_untested = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      if (num_untested > 0 && i + 1 < size) {
        --num_untested;
        for (std::uint32_t k = 0; k < kBlock; ++k) next[num_next++] = queue[i] * kBlock + k;
        continue;
      }
      const std::uint32_t before = num_next;
      const SphereBlock& block = in.spheres[in.level_begin[level] + queue[i]];
      for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
        const F bound = BoundSpheres(in, block, at);
        const I is_near = bound <= in.margin;
        free_distance = Min(free_distance, is_near ? Fill(1e30f) : bound);
        const unsigned lanes = Bits(is_near);
        if (lanes == 0) continue;
        if (cull->estimates != nullptr && level == 0) {
          Compress(reinterpret_cast<std::uint32_t*>(cull->estimates) + num_next, (U)EstimateLeaves(in, block, at),
                   lanes);
        }
        Compress(next + num_next, LaneNumbers() + (queue[i] * kBlock + static_cast<std::uint32_t>(at)), lanes);
        num_next += static_cast<std::uint32_t>(__builtin_popcount(lanes));
      }
      cull->spheres_tested += kBlock;
      if (level > 0 || cull->estimates != nullptr) continue;
      leap = num_next - before < kBlock ? 1 : (leap < kMostLeap ? 2 * leap : leap);
      num_untested = leap - 1;
    }
    std::uint32_t* const swapped = queue;
    queue = next;
    next = swapped;
    size = num_next;
  }
  cull->blocks = queue;
  cull->num_blocks = size;
  cull->free_distance = Least(free_distance);
}

#include "vps/walk/facet_lanes.hpp"
#include "vps/walk/walk_points.hpp"

// Uses the ones above.
#include "vps/surface/patch_lanes.hpp"
