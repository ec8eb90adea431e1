// Body of the walk kernels, included by one file per instruction set, which defines before, inside namespace vps and
// an anonymous namespace: kLanes (4, 8 or 16), the vector types F, I, U of so many float, int32, uint32, and
//   U Gather(const std::uint32_t* base, U index);   F Sqrt(F);   unsigned Bits(I mask);
//   unsigned EqualBits(U a, U b);   unsigned LessBits(F a, F b);
//   F Fma(F a, F b, F c);                           a b + c, rounded once
//   Octet, Octet LoadOctet(const std::uint32_t* corner, std::size_t stride_y, std::size_t stride_z);
//   U LookUp(const Octet&, U index);                eight values by index 0 ... 7
//   Place, Place LoadPlace(const std::uint32_t* sixteen);   U PlaceOf(const Place&, U coordinate);   by its last 4 bits
//   Compress(std::uint32_t* to, U v, unsigned mask);   the masked lanes, one after the other; may write a whole U
// Vectors are GCC's: arithmetic and ?: work lane by lane, a comparison gives 0 or -1 per lane.

constexpr int kParts = kBlock / kLanes;  // registers per block
constexpr unsigned kAllLanes = (1U << kLanes) - 1;
constexpr unsigned kAllSurvive = 0xffffU;

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

inline F WordDistance(U word) {
  return ToF((I)word) * kWordScale;
}
// field_word.hpp; every shift leaves the code in the seven uppermost bits.
inline F PlaneAt(U word, const Vec3& e) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  const Vec3 g{ToF((I)(word << 11 & kTop)), ToF((I)(word << 18 & kTop)), ToF((I)(word << 25))};
  return Fma(ToF((I)word), Fill(kWordScale / kGradientScale), Dot(g, e)) * kGradientScale;
}
// Of a record's four words.
inline F CreaseFrom(U first, U second, U third, U fourth, const Vec3& e) {
  const F side = (I)(first << 10) < 0 ? Fill(-1.0f) : Fill(1.0f);
  const I is_nested = (I)(second << 10) < 0;
  const F u0 = side * PlaneAt(first, e);
  const F u1 = side * PlaneAt(second, e);
  const F u2 = side * PlaneAt(third, e);
  const F u3 = side * PlaneAt(fourth, e);
  const F a = is_nested ? Min(u0, u1) : Max(u0, u1);
  const F b = is_nested ? Min(u2, u3) : Max(u2, u3);
  return side * Max(a, b);
}
inline F CreaseAt(const WalkInput& in, U record, const Vec3& e) {
  const U at = record * kPlanesPerCrease;
  return CreaseFrom(Gather(in.creases, at), Gather(in.creases + 1, at), Gather(in.creases + 2, at),
                    Gather(in.creases + 3, at), e);
}

inline U WordInBrickOf(I x, I y, I z) {
  return (U)((x & 3) | (y & 1) << 2 | (z & 1) << 3 | (x >> 2 & 1) << 4 | (y >> 1 & 3) << 5 | (z >> 1 & 3) << 7);
}

// The coarse grid's cell that a place in the grid lies in, and the place from the cell's middle.
inline U CoarseCellAt(const WalkInput& in, const Vec3& q, Vec3* e) {
  const int shift = in.coarse_shift;
  const I x = ToI(q.x) >> shift;
  const I y = ToI(q.y) >> shift;
  const I z = ToI(q.z) >> shift;
  const float half = static_cast<float>(1 << shift) * 0.5f;
  *e = {q.x - ToF(x << shift) - half, q.y - ToF(y << shift) - half, q.z - ToF(z << shift) - half};
  return (U)((z * (in.ny >> shift) + y) * (in.nx >> shift) + x);
}
// The cell's model, from its distance and its gradient's code.
inline F CoarseFrom(U distance, U code, const Vec3& e) {
  constexpr std::uint32_t kTop = 0xff000000U;
  const Vec3 g{ToF((I)(code << 24 & kTop)), ToF((I)(code << 16 & kTop)), ToF((I)(code << 8 & kTop))};
  return Fma(Dot(g, e), Fill(kCoarseGradientScale), (F)distance);
}
// The coarse grid's distance of points inside the grid, of the masked lanes.
template <bool kBound>
inline F CoarseAt(const WalkInput& in, const Vec3& q, I lanes) {
  Vec3 e;
  const U at = ((U)lanes & CoarseCellAt(in, q, &e)) * 2;
  const std::uint32_t* const cells = reinterpret_cast<const std::uint32_t*>(in.coarse);
  const U distance = Gather(cells, at);
  if (kBound) return (F)distance - Length(e);
  return CoarseFrom(distance, Gather(cells + 1, at), e);
}

// The grid's place nearest to p.
inline Vec3 ClampToGrid(const WalkInput& in, const Vec3& p) {
  return {Min(Max(p.x, F{}), Fill(static_cast<float>(in.nx) - 0.5f)),
          Min(Max(p.y, F{}), Fill(static_cast<float>(in.ny) - 0.5f)),
          Min(Max(p.z, F{}), Fill(static_cast<float>(in.nz) - 0.5f))};
}

// Field at points in voxels, anywhere, as SampleField. kBound: lower bound of the distance by way of the cell's centre
// (spheres); else the model's distance (points).
template <bool kBound>
inline F SampleAnywhere(const WalkInput& in, const Vec3& p) {
  const Vec3 q = ClampToGrid(in, p);
  const I cx = ToI(q.x);
  const I cy = ToI(q.y);
  const I cz = ToI(q.z);
  const U brick = Gather(in.bricks, (U)(((cz >> 3) * (in.ny >> 3) + (cy >> 3)) * (in.nx >> 3) + (cx >> 3)));
  const U word = Gather(in.words, brick + WordInBrickOf(cx, cy, cz));
  const Vec3 e{q.x - ToF(cx) - 0.5f, q.y - ToF(cy) - 0.5f, q.z - ToF(cz) - 0.5f};
  const I is_other = (I)((word & 0x7fU) == kOtherKind);
  const I is_coarse = (I)(word == kCoarseWord);
  const I is_crease = is_other & ~is_coarse;
  F d = kBound ? WordDistance(word) - Length(e) : PlaneAt(word, e);
  if (Bits(is_crease) != 0) d = is_crease ? CreaseAt(in, (U)(is_crease & (I)(word >> 7)), e) : d;
  if (Bits(is_coarse) != 0) d = is_coarse ? CoarseAt<kBound>(in, q, is_coarse) : d;
  const F outside = Max(Max(Abs(p.x - q.x), Abs(p.y - q.y)), Abs(p.z - q.z));
  return outside > 0.0f ? Max(d, outside) : d;
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

inline float Most(F v) {
  return -Least(-v);
}

// Plane of a voxel's word at places in it, with the gradient.
inline F PlaneAndGradient(U word, const Vec3& e, Vec3* g) {
  constexpr std::uint32_t kTop = 0xfe000000U;
  *g = {ToF((I)(word << 11 & kTop)) * kGradientScale, ToF((I)(word << 18 & kTop)) * kGradientScale,
        ToF((I)(word << 25)) * kGradientScale};
  return Dot(*g, e) + WordDistance(word);
}

// How far the points of a sphere's slab can lie below its centre in the plane with gradient g: the slab reaches r
// across its unit normal n and h along it, so  depth = r |g - (g . n) n| + h |g . n|;  rate: its growth when r and h
// grow by 1.
struct Sink {
  F depth, rate;
};
inline Sink FindSink(const WalkInput& in, const Vec3& g, const Vec3& n, F r, F h) {
  const F across = Abs(Dot(g, n) * in.m_per_voxel);  // n is turned and scaled by voxels_per_m
  const F along = Sqrt(Max(Dot(g, g) - across * across, F{}) + 1e-5f);
  return {Fma(r, along, h * across), along + across};
}

// Conservative bounds of the spheres of level 0. reach: lower bound of the field, the largest of three: by the distance
// at the coarse cell's centre (less kCullSlack); by that cell's plane and its wide bound; by the plane of the voxel
// that the centre is in and the close bound (CoarseCell). slack: how far, up to `skin`, all points may move before the
// first of them can come within the margin; not positive where reach is within it. Points that have moved by x lie in a
// sphere and a slab wider by x.
struct Leaves {
  F reach, slack;
};
template <bool kWithSlack>
inline Leaves BoundLeaves(const WalkInput& in, const SphereBlock& block, int at, float skin) {
  const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
  const F r = LoadF(block.r + at) * in.voxels_per_m;
  const F h = LoadF(block.h + at) * in.voxels_per_m;
  const Vec3 q = ClampToGrid(in, p);
  const int shift = in.coarse_shift;
  const I vx = ToI(q.x);
  const I vy = ToI(q.y);
  const I vz = ToI(q.z);
  const I x = vx >> shift;
  const I y = vy >> shift;
  const I z = vz >> shift;
  const std::uint32_t* const cells = reinterpret_cast<const std::uint32_t*>(in.coarse);
  const U cell = (U)(((z * (in.ny >> shift) + y) * (in.nx >> shift) + x) * 2);
  const U distance = Gather(cells, cell);
  const U code = Gather(cells + 1, cell);
  const float side = static_cast<float>(1 << shift);
  const Vec3 off{q.x - (ToF(x) + 0.5f) * side, q.y - (ToF(y) + 0.5f) * side, q.z - (ToF(z) + 0.5f) * side};
  const F outside = Max(Max(Abs(p.x - q.x), Abs(p.y - q.y)), Abs(p.z - q.z));
  const F centre = (F)distance - Length(off);
  F reach = (outside > 0.0f ? Max(centre, outside) : centre) - r - kCullSlack;
  F slack = reach - in.margin;

  const Vec3 n = Turn(in, LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at));
  const F widest = r + skin;
  const auto take = [&](F plane, const Vec3& g, I holds) {
    const Sink sink = FindSink(in, g, n, r, h);
    const F least = plane - sink.depth;
    reach = holds ? Max(reach, least) : reach;
    if (kWithSlack) slack = holds ? Max(slack, (least - in.margin) / sink.rate) : slack;
  };
  constexpr std::uint32_t kTop = 0xff000000U;
  const U wide = distance & 0xffU;
  const Vec3 g{ToF((I)(code << 24 & kTop)) * kCoarseGradientScale, ToF((I)(code << 16 & kTop)) * kCoarseGradientScale,
               ToF((I)(code << 8 & kTop)) * kCoarseGradientScale};
  take((F)distance + Dot(g, off) - ToF((I)wide - 1) * (1.0f / kFallSteps), g, ((I)wide != 0) & (widest <= kWideMargin));
  const I is_small = (widest <= kCloseRadius) & (kWithSlack ? slack <= skin : reach <= in.margin);
  if (Bits(is_small) != 0) {
    const U brick = Gather(in.bricks, (U)(((vz >> 3) * (in.ny >> 3) + (vy >> 3)) * (in.nx >> 3) + (vx >> 3)));
    const U word = Gather(in.words, brick + WordInBrickOf(vx, vy, vz));
    const U close = code >> 24;
    Vec3 own;
    const F plane = PlaneAndGradient(word, {q.x - ToF(vx) - 0.5f, q.y - ToF(vy) - 0.5f, q.z - ToF(vz) - 0.5f}, &own);
    take(plane - ToF((I)close - 1) * (1.0f / kFallSteps), own,
         is_small & ((I)close != 0) & ((I)((word & 0x7fU) != kOtherKind)) &
             (Abs(WordDistance(word)) <= kMostAnchorDistance));
  }
  return {reach, slack};
}

constexpr std::uint32_t kMostLeap = 4;  // blocks of spheres taken untested; not derived

// Estimate of the least distance of the points of each sphere of level 0: the field at its centre, less the depth of
// the slab towards the surface there.
inline F EstimateLeaves(const WalkInput& in, const SphereBlock& block, int at) {
  const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
  const F d = SampleAnywhere<false>(in, p);
  // By central differences of half a voxel: across creases too.
  const float step = 0.5f;
  const Vec3 g{SampleAnywhere<false>(in, {p.x + step, p.y, p.z}) - SampleAnywhere<false>(in, {p.x - step, p.y, p.z}),
               SampleAnywhere<false>(in, {p.x, p.y + step, p.z}) - SampleAnywhere<false>(in, {p.x, p.y - step, p.z}),
               SampleAnywhere<false>(in, {p.x, p.y, p.z + step}) - SampleAnywhere<false>(in, {p.x, p.y, p.z - step})};
  const Vec3 n = Turn(in, LoadF(block.nx + at), LoadF(block.ny + at), LoadF(block.nz + at));
  const F r = LoadF(block.r + at) * in.voxels_per_m;
  return d - FindSink(in, g, n, r, LoadF(block.h + at) * in.voxels_per_m).depth;
}

// kSlack: spheres that may come near within the skin survive, and their slack is kept. kEstimate: the estimate is kept.
enum class Kept { kNothing, kSlack, kEstimate };
template <Kept kKept>
inline void CullBy(const WalkInput& in, WalkCull* cull) {
  std::uint32_t* queue = cull->queue;
  std::uint32_t* next = cull->queue + cull->queue_half;
  std::uint32_t size = 1;
  queue[0] = 0;
  F free_distance = Fill(1e30f);
  cull->spheres_tested = 0;
  constexpr bool kWithSlack = kKept == Kept::kSlack;
  const float skin = kWithSlack ? cull->skin : 0.0f;
  for (std::uint32_t level = in.num_levels; level-- > 0;) {
    const SphereBlock* const blocks = in.spheres + in.level_begin[level];
    std::uint32_t num_next = 0;
    // Where everything survives, in deep or conforming contact, testing spheres only costs: after a block of level 0
    // without loss the next one is taken as it is, then the next three.
    std::uint32_t leap = 1;
    std::uint32_t num_untested = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const SphereBlock& block = blocks[queue[i]];
      if (num_untested > 0 && queue[i] != in.last_leaves) {
        --num_untested;
        for (std::uint32_t k = 0; k < kBlock; ++k) next[num_next++] = queue[i] * kBlock + k;
        continue;
      }
      unsigned survivors = 0;
      for (int j = 0; j < kParts; ++j) {
        const int at = j * kLanes;
        const F r = LoadF(block.r + at) * in.voxels_per_m;
        Leaves leaves{Fill(-1e30f), Fill(-1e30f)};
        if (level == 0) leaves = BoundLeaves<kWithSlack>(in, block, at, skin);
        const I is_wide = level != 0 ? ~I{} : (I)(r + skin > kWideMargin);
        if (Bits(is_wide) != 0) {
          const Vec3 p = ToVoxels(in, LoadF(block.x + at), LoadF(block.y + at), LoadF(block.z + at));
          const F reach = SampleAnywhere<true>(in, p) - r - kCullSlack;
          // Not of the others, so that what survives does not depend on how many share a register.
          leaves = {is_wide ? Max(leaves.reach, reach) : leaves.reach,
                    is_wide ? Max(leaves.slack, reach - in.margin) : leaves.slack};
        }
        const I is_near = kWithSlack ? leaves.slack <= skin : leaves.reach <= in.margin;
        free_distance = Min(free_distance, is_near ? Fill(1e30f) : leaves.reach);
        unsigned lanes = Bits(is_near);
        survivors |= lanes << at;
        if (kKept != Kept::kNothing && level == 0) {
          const std::uint32_t to = num_next + static_cast<std::uint32_t>(__builtin_popcount(survivors ^ lanes << at));
          const F kept = kWithSlack ? leaves.slack : EstimateLeaves(in, block, at);
          Compress(reinterpret_cast<std::uint32_t*>(cull->kept) + to, (U)kept, lanes);
        }
      }
      cull->spheres_tested += kBlock;
      if (kKept == Kept::kNothing && level == 0) {
        leap = survivors != kAllSurvive ? 1 : (leap < kMostLeap ? 2 * leap : leap);
        num_untested = leap - 1;
      }
      for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
        const unsigned lanes = survivors >> at & kAllLanes;
        if (lanes == 0) continue;
        Compress(next + num_next, LaneNumbers() + (queue[i] * kBlock + static_cast<std::uint32_t>(at)), lanes);
        num_next += static_cast<std::uint32_t>(__builtin_popcount(lanes));
      }
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

void Cull(const WalkInput& in, WalkCull* cull) {
  if (cull->kept == nullptr) {
    CullBy<Kept::kNothing>(in, cull);
  } else if (cull->skin > 0.0f) {
    CullBy<Kept::kSlack>(in, cull);
  } else {
    CullBy<Kept::kEstimate>(in, cull);
  }
}

// From the coarse grid alone, so that little memory is touched. Outside the grid, which is convex, the angle at the
// grid's nearest place q between p and any place of the surface is not acute: the distance is |p - q| and that of q, as
// the sides of a right angle.
void BoundSpheres(const WalkInput& in, std::uint32_t block, std::int32_t* keys) {
  const SphereBlock& spheres = in.spheres[block];
  for (int at = 0; at < static_cast<int>(kBlock); at += kLanes) {
    const F x = LoadF(spheres.x + at);
    const Vec3 p = ToVoxels(in, x, LoadF(spheres.y + at), LoadF(spheres.z + at));
    const Vec3 q = ClampToGrid(in, p);
    const Vec3 out{p.x - q.x, p.y - q.y, p.z - q.z};
    const F outside = Dot(out, out);
    const F inside = CoarseAt<true>(in, q, ~I{});
    const F at_least = Max(inside, F{});
    const F d = outside > 0.0f ? Sqrt(Fma(at_least, at_least, outside)) : inside;
    const F free_distance = Min(d - LoadF(spheres.r + at) * in.voxels_per_m - kCullSlack, Fill(kMaxFreeDistance));
    const F bound = x < SampleTree::kFarAway_m ? free_distance : Fill(kNoSphere);
    const I steps = ToI(bound * static_cast<float>(kFreeDistanceSteps));
    StoreU(reinterpret_cast<std::uint32_t*>(keys + at),
           (U)(steps * 16) + LaneNumbers() + static_cast<std::uint32_t>(at));
  }
}

#include "vps/walk/facet_lanes.hpp"
#include "vps/walk/walk_points.hpp"

// Uses the ones above.
#include "vps/surface/patch_lanes.hpp"
