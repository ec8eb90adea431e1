#include "vps/multibody/gap_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/field/four_lanes.hpp"
#include "vps/field/nearest_facet.hpp"
#include "vps/force/direction_bins.hpp"
#include "vps/mesh/nearest_on_triangle.hpp"
#include "vps/multibody/block_sums.hpp"
#include "vps/sampling/nearest_piece.hpp"
#include "vps/sampling/sharp_edges.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
// Faces, edges and corners of each direction: of two that are equally near none stands for the other.
constexpr std::size_t kNumBins = 3 * kNumDirectionBins;
constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr float kPad = 1.0f + 1e-5f;  // against the rounding of floats
// A place gets its exact gap when it can be nearer than this by the field [voxels]: beyond, what the field is
// off by does not matter before the next cycle.
constexpr double kExactWithin = 0.5;
// From a point this much off the surface it is clear which face, edge or corner of G is below [voxels].
constexpr double kClear = 0.02;
constexpr double kSlope = 1e-3;  // faces with less between them are along each other
constexpr int kMostHops = 5;
// Pieces of an edge are searched beyond their ends: where an edge of G passes under the common end of two, each sees
// the faces on both sides of it. From as far as kClear above an edge of G both are equally near (not derived).
constexpr double kOverlap = 1.5;
constexpr int kHalvings = 4;  // of the way between two places above different faces, to find those that are neighbours
// Places of a bin that are measured exactly to find the nearest, and corners of G that are measured: not derived, the
// time for a cycle bounds them.
constexpr std::size_t kMostLikely = 4;
constexpr std::size_t kMostCorners = 32;
// Blocks of places with the deepest of a bin, in which those that can be nearest along their piece of edge are sought.
// Not derived, for the same reason; a piece's neighbours along its edge are in its block or in one next to it.
constexpr std::size_t kMostDeep = 8;
// A corner of G is measured if a place of S is nearer to it than this [spacings]: on a square grid of places the
// farthest is half a diagonal away, 0.71; places are not on a grid (not derived).
constexpr double kAroundCorner = 2.0;
// By the field a normal is less sure than by facets: one that is farther outside a place's own than this is not its
// own.
constexpr double kBesideByField = kSharpAngle_deg * 3.14159265358979 / 180.0;
constexpr double kDoubt = static_cast<double>(kUsualFieldError);
constexpr std::uint32_t kCornerOfG = 1U << 31U;  // in the name of a corner of G
constexpr double kLeastShare = 0.05;             // of the stiffness, of a plane far away: as ReducePatches
// Faces whose normals differ by less are one, edges that do are parallel: sines, squared.
constexpr double kSameFace = 1e-4;
constexpr double kParallel = 1e-6;

constexpr std::uint32_t kSpread = 16;  // not derived

// A place, and the most depth that the field and its slope there leave to the piece of edge around it [voxels].
struct Likely {
  std::uint32_t point = kNone;
  float depth = -kFar;
};

// Places of a block in a bin, by the deepest of them.
struct DeepGroup {
  float depth = -kFar;
  std::uint32_t near = 0;  // of the walk's near blocks
  std::uint16_t lanes = 0;
};

// A direction of S's surface: its nearest place, and those that are far from it on four sides without being much
// farther away.
struct Bin {
  std::uint32_t nearest = kNone;
  float nearest_depth = -kFar;  // voxels
  glm::vec3 p{0.0f};
  std::array<std::uint32_t, 4> outer{kNone, kNone, kNone, kNone};
  std::array<float, 4> merits{};
  std::array<float, 4> depths{};
  core::FixedVector<DeepGroup, kMostDeep> deep;
  // Those that can be nearest somewhere along their piece of edge, the likeliest first.
  core::FixedVector<Likely, kMostLikely> likely;
};

// Into a list of the deepest, the first of equal ones first.
template <class T, std::size_t N>
void OfferByDepth(const T& one, core::FixedVector<T, N>* list) {
  if (list->full() && list->back().depth >= one.depth) return;
  if (list->full()) list->resize(N - 1);
  list->push_back(one);
  for (std::size_t i = list->size() - 1; i > 0 && (*list)[i - 1].depth < (*list)[i].depth; --i) {
    std::swap((*list)[i - 1], (*list)[i]);
  }
}

enum class Rank : std::uint8_t { kLoaded, kNearest, kOther };

struct Candidate {
  std::uint32_t point = 0;
  float depth = 0.0f;  // voxels
  Rank rank = Rank::kOther;
  std::int8_t slot = -1;
  std::uint16_t turn = 0;  // of its direction

  bool operator<(const Candidate& other) const {
    if (turn != other.turn) return turn < other.turn;
    if (rank != other.rank) return rank < other.rank;
    return depth != other.depth ? depth > other.depth : point < other.point;
  }
};

// Corners of G's triangles below places of S. In G, voxels, with the normal of the place.
struct Below {
  struct Corner {
    glm::dvec3 p;
    glm::dvec3 n;
    double height = 0.0;  // of the place
  };
  core::FixedVector<Corner, kMostCorners> corners;

  void Add(const NearestFacet& facet, const glm::dvec3& p, const glm::dvec3& n, double height, double reach) {
    for (const glm::dvec3& corner : facet.corners) {
      const glm::dvec3 way = corner - p;
      if (glm::dot(way, way) > reach * reach) continue;
      const auto* known = std::find_if(corners.begin(), corners.end(), [&](const Corner& c) { return c.p == corner; });
      if (known == corners.end()) corners.push_back({corner, n, height});
    }
  }
};

struct Gap {
  bool is_found = false;
  glm::dvec3 p{0.0};  // of S, in G, voxels
  glm::dvec3 n{0.0};  // from G to S, unit
  double height = 0.0;

  [[nodiscard]] glm::dvec3 OnG() const { return p - height * n; }
};

// The least one, and in a groove of G the one to its other face.
struct Gaps {
  Gap least;
  Gap other;
};

// A place of S that was measured exactly, or a corner of G: `point` is its name then.
struct Measured {
  std::uint32_t point = kNone;
  Gaps gaps;
  glm::dvec3 corner{0.0};  // voxels
};

// Lane of the first of the deepest.
std::uint32_t DeepestOf(const float* depths, unsigned lanes) {
  auto deepest = static_cast<std::uint32_t>(__builtin_ctz(lanes));
  if (lanes == 0xffffU) {
    const F4 four = Max4(Max4(Load4(depths), Load4(depths + 4)), Max4(Load4(depths + 8), Load4(depths + 12)));
    const float most = std::max(std::max(four[0], four[1]), std::max(four[2], four[3]));
    while (depths[deepest] != most) ++deepest;
    return deepest;
  }
  for (unsigned rest = lanes & (lanes - 1); rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::uint32_t>(__builtin_ctz(rest));
    if (depths[k] > depths[deepest]) deepest = k;
  }
  return deepest;
}

struct Query {
  const TouchPoints& S;
  const DistanceField& field;
  const core::Pose& X_GS;
  const FieldWalkScratch& walk;
  const FieldWalkResult& result;
  float margin;  // voxels
  glm::mat3 R_GS;
  glm::dmat3 voxels_per_S;  // and S's origin: to G, voxels
  glm::dvec3 p_GSo;
  std::array<Bin, kNumBins> bins;
  core::FixedVector<Candidate, 5 * kNumBins + kMostCorners + kMaxGapPlaces> candidates;
  core::FixedVector<Measured, kMostLikely * kNumBins + kMostCorners> measured;
  FacetsAround around;

  // take(group, near): the groups of a near block.
  template <class Take>
  void ForEachGroup(std::uint32_t near, const Take& take) const {
    const std::uint32_t block = walk.near_blocks[near];
    for (std::uint32_t g = S.group_begin[block]; g < S.group_begin[block + 1]; ++g) take(S.groups[g], near);
  }
  // take(point, depth): the near places of a group.
  template <class Take>
  void ForEachNear(std::uint16_t lanes, std::uint32_t near, const Take& take) const {
    const std::uint32_t first = walk.near_blocks[near] * kBlock;
    const float* const depths = walk.depths(near);
    for (unsigned rest = lanes; rest != 0; rest &= rest - 1) {
      const auto k = static_cast<std::uint32_t>(__builtin_ctz(rest));
      if (depths[k] >= -margin) take(first + k, depths[k]);
    }
  }
  [[nodiscard]] glm::vec3 PointAt(std::uint32_t point) const {
    return PointOf(S.tree.points[point / kBlock], point % kBlock);
  }
  [[nodiscard]] const Measured* Find(std::uint32_t point) const {
    for (const Measured& one : measured) {
      if (one.point == point) return &one;
    }
    return nullptr;
  }
  [[nodiscard]] float DepthOf(std::uint32_t point) const {
    if ((point & kCornerOfG) != 0) {
      const Measured* const corner = Find(point);
      return corner != nullptr ? -static_cast<float>(corner->gaps.least.height) : -kFar;
    }
    const auto begin = walk.near_blocks.begin();
    const auto end = begin + result.num_near_blocks;
    const auto at = std::lower_bound(begin, end, point / kBlock);
    if (at == end || *at != point / kBlock) return -kFar;
    return walk.depths(static_cast<std::uint32_t>(at - begin))[point % kBlock];
  }

  // In which the tool is pushed there.
  [[nodiscard]] std::size_t DirectionOf(std::uint32_t point) const {
    if ((point & kCornerOfG) == 0) return S.places[point].bin;
    return DirectionBin(glm::vec3(glm::conjugate(X_GS.rotation) * Find(point)->gaps.least.n));
  }
  Bin& BinOf(const TouchGroup& group) {
    return bins[static_cast<std::size_t>(group.kind) * kNumDirectionBins + group.bin];
  }
  void FillBins() {
    const auto find_deepest = [&](const TouchGroup& group, std::uint32_t near) {
      const float* const depths = walk.depths(near);
      const std::uint32_t at = DeepestOf(depths, group.lanes);
      const float deepest = depths[at];
      if (!(deepest >= -margin)) return;
      Bin& bin = BinOf(group);
      OfferByDepth({deepest, near, group.lanes}, &bin.deep);
      if (deepest <= bin.nearest_depth) return;
      bin.nearest_depth = deepest;
      bin.nearest = walk.near_blocks[near] * kBlock + at;
    };
    for (std::uint32_t i = 0; i < result.num_near_blocks; ++i) ForEachGroup(i, find_deepest);
    for (Bin& bin : bins) {
      if (bin.nearest == kNone) continue;
      bin.p = PointAt(bin.nearest);
      FindLikely(&bin);
    }
    // Blocks next to each other follow each other: after some from everywhere few are farther out than those before.
    const auto find_outer = [&](const TouchGroup& group, std::uint32_t near) { FindOuter(group, near, &BinOf(group)); };
    for (std::uint32_t i = 0; i < result.num_near_blocks; i += kSpread) ForEachGroup(i, find_outer);
    for (std::uint32_t i = 0; i < result.num_near_blocks; ++i) {
      if (i % kSpread != 0) ForEachGroup(i, find_outer);
    }
  }
  void FindOuter(const TouchGroup& group, std::uint32_t near, Bin* bin) const {
    if (bin->nearest == kNone) return;
    const Tangents& tangents = BinTangents(group.bin);
    const std::uint32_t block = walk.near_blocks[near];
    const SphereBlock& spheres = S.tree.spheres[S.tree.level_begin[0] + block / kBlock];
    const std::uint32_t j = block % kBlock;
    // What none of the block's places exceeds. A place far above the nearest one has a negative weight.
    const glm::vec3 middle = glm::vec3(spheres.x[j], spheres.y[j], spheres.z[j]) - bin->p;
    const float u_0 = glm::dot(middle, tangents.u);
    const float v_0 = glm::dot(middle, tangents.v);
    const float below = std::max(bin->nearest_depth / margin, 0.0f);
    const float radius = spheres.r[j] * kPad;
    const auto most = [&](float at) { return std::max(at + radius, below * (radius - at)) * kPad; };
    if (most(u_0) <= bin->merits[0] && most(v_0) <= bin->merits[1] && most(-u_0) <= bin->merits[2] &&
        most(-v_0) <= bin->merits[3]) {
      return;
    }
    ForEachNear(group.lanes, near, [&](std::uint32_t point, float depth) {
      const glm::vec3 r = PointAt(point) - bin->p;
      const float weight = 1.0f - (bin->nearest_depth - depth) / margin;
      const float u = weight * glm::dot(r, tangents.u);
      const float v = weight * glm::dot(r, tangents.v);
      const std::array<float, 4> merits{u, v, -u, -v};
      for (std::size_t k = 0; k < 4; ++k) {
        if (merits[k] <= bin->merits[k]) continue;
        bin->merits[k] = merits[k];
        bin->outer[k] = point;
        bin->depths[k] = depth;
      }
    });
  }
  // In the order of the places, so that of equally likely ones the same is the first whichever block is deepest.
  void FindLikely(Bin* bin) {
    std::sort(bin->deep.begin(), bin->deep.end(),
              [](const DeepGroup& a, const DeepGroup& b) { return a.near < b.near; });
    for (const DeepGroup& group : bin->deep) {
      ForEachNear(group.lanes, group.near, [&](std::uint32_t point, float depth) {
        const float most = depth + S.places[point].reach_m / static_cast<float>(field.voxel_size_m);
        if (bin->likely.full() && bin->likely.back().depth >= most) return;
        OfferByDepth({point, MostOf(point, depth)}, &bin->likely);
      });
    }
  }
  // Over an edge or a corner of G the gap falls along S away from its place, but no faster than there.
  [[nodiscard]] float MostOf(std::uint32_t point, float depth) const {
    const TouchPlace& place = S.places[point];
    if (place.kind == TouchPlace::Kind::kCorner) return depth;
    const glm::vec3 n = SampleField(field, glm::vec3(InVoxels(PointAt(point)))).gradient;
    const float slope = place.kind == TouchPlace::Kind::kEdge ? std::abs(glm::dot(n, R_GS * place.along))
                                                              : glm::length(glm::cross(n, R_GS * place.inward));
    return depth + slope * place.reach_m / static_cast<float>(field.voxel_size_m);
  }
  [[nodiscard]] glm::dvec3 InVoxels(const glm::vec3& p_S) const { return voxels_per_S * glm::dvec3(p_S) + p_GSo; }

  // The gaps of a place, exact where they can be small; not found on the side that faces away.
  Gaps Measure(std::uint32_t point, double depth, Below* below);
  Gaps ByFacets(const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along_G, const glm::dvec3& inward_G,
                double depth, Below* below);
  Gap OverOtherFace(const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along_G, const glm::dvec3& inward_G,
                    double depth, const Gap& least, const NearestFacet& face);
  [[nodiscard]] bool IsOnS(const glm::dvec3& p, const glm::dvec3& inward_G) const;
  [[nodiscard]] double Beside() const;
  Gaps GapsOf(std::uint32_t point, double depth, Below* below);
  void MeasureNearest(Below* below);
  glm::dvec3 Carrying(const glm::dvec3& corner, glm::dvec3 n);
  void MeasureCorners(const Below& below);

  void Offer(const Candidate& candidate) {
    for (Candidate& known : candidates) {
      if (known.point != candidate.point) continue;
      known.rank = std::min(known.rank, candidate.rank);
      known.slot = std::max(known.slot, candidate.slot);
      return;
    }
    candidates.push_back(candidate);
  }
  // Where there are more than slots, the directions choose in turns: a flank that is pressed on has many places that
  // are nearer than the nearest of the flank across, which is what the tool comes to when it is pulled back.
  void TakeInTurns() {
    if (candidates.size() <= kMaxGapPlaces) return;
    std::array<std::uint16_t, kNumDirectionBins> counts{};
    for (Candidate& c : candidates) c.turn = counts[DirectionOf(c.point)]++;
    std::sort(candidates.begin(), candidates.end());
    candidates.resize(kMaxGapPlaces);
  }
  // Those of this cycle first, so that these renew the slots of the last ones.
  void Choose(GapPlanes* gaps) {
    for (const Bin& bin : bins) {
      if (bin.nearest != kNone) Offer({bin.nearest, bin.nearest_depth, Rank::kNearest});
    }
    for (const Bin& bin : bins) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (bin.outer[k] != kNone) Offer({bin.outer[k], bin.depths[k]});
      }
    }
    for (const Measured& one : measured) {
      if ((one.point & kCornerOfG) != 0) Offer({one.point, -static_cast<float>(one.gaps.least.height), Rank::kNearest});
    }
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      GapPlanes::Slot& slot = gaps->slots[s];
      if (slot.cycles_left < 0) continue;
      const float depth = DepthOf(slot.point);
      const std::size_t before = candidates.size();
      const Rank rank = slot.is_loaded ? Rank::kLoaded : Rank::kOther;
      if (depth >= -margin) Offer({slot.point, depth, rank, static_cast<std::int8_t>(s)});
      const bool is_renewed = depth >= -margin && (slot.is_loaded || candidates.size() == before);
      slot.is_loaded = false;
      slot.cycles_left = static_cast<std::int8_t>(is_renewed ? GapPlanes::kStay : slot.cycles_left - 1);
      if (candidates.size() > before && slot.cycles_left < 0) candidates.resize(before);
      if (!(depth >= -margin)) slot.cycles_left = -1;
    }
    std::sort(candidates.begin(), candidates.end());
    TakeInTurns();
    // Slots of those that give way are free.
    std::array<bool, kMaxGapPlaces> is_taken{};
    for (const Candidate& c : candidates) {
      if (c.slot >= 0) is_taken[static_cast<std::size_t>(c.slot)] = true;
    }
    std::size_t next = 0;
    for (Candidate& c : candidates) {
      if (c.slot >= 0) continue;
      while (is_taken[next]) ++next;
      is_taken[next] = true;
      c.slot = static_cast<std::int8_t>(next);
      gaps->slots[next] = {c.point, GapPlanes::kStay};
    }
    for (const Candidate& c : candidates) {
      GapPlanes::Slot& slot = gaps->slots[static_cast<std::size_t>(c.slot)];
      if ((c.point & kCornerOfG) == 0) continue;
      slot.corner = Find(c.point)->corner;
    }
    for (std::size_t s = 0; s < kMaxGapPlaces; ++s) {
      if (!is_taken[s]) gaps->slots[s] = {};
    }
  }
};

Gap ByField(const DistanceField& field, const glm::dvec3& p) {
  const FieldSample sample = SampleField(field, glm::vec3(p));
  return {true, p, glm::normalize(glm::dvec3(sample.gradient)), static_cast<double>(sample.distance)};
}

double ReachOf(double depth) {
  return std::abs(depth) + static_cast<double>(kMostFieldError);
}

bool IsSameFace(const NearestFacet& a, const NearestFacet& b) {
  const glm::dvec3 e = glm::cross(a.normal, b.normal);
  return glm::dot(e, e) < kSameFace;
}
bool MeetInAConvexEdge(const NearestFacet& a, const NearestFacet& b) {
  const auto is_below = [](const NearestFacet& one, const NearestFacet& other) {
    const glm::dvec3 middle = (one.corners[0] + one.corners[1] + one.corners[2]) / 3.0;
    return glm::dot(middle - other.corners[0], other.normal) < 0.0;
  };
  return is_below(a, b) && is_below(b, a);
}

// An edge of S over an edge of G: the gap, and the face of G whose normal is nearer to the gap's.
struct Crossing {
  Gap gap;
  NearestFacet face;
};

// Where a piece of a sharp edge of S, along `along`, passes over an edge of G: between two of its places that are above
// different faces of G, whose planes meet in G's edge. The normal is across both edges.
Crossing OverEdge(const FacetsAround& around, double reach, const glm::dvec3& p, const glm::dvec3& along,
                  const glm::dvec3& inward_G, double depth) {
  const double back = std::max(depth, 0.0) + kClear;
  const auto find = [&](double share) {
    const double way = share * kOverlap * reach;
    return around.FindNearest(p + way * along + back * inward_G, back + ReachOf(depth) + std::abs(way));
  };
  const std::array<NearestFacet, 3> below{find(-1.0), find(0.0), find(1.0)};
  Crossing least;
  for (std::size_t i = 0; i < 2; ++i) {
    NearestFacet a = below[i];
    NearestFacet b = below[i + 1];
    if (!a.is_found || !b.is_found || IsSameFace(a, b)) continue;
    double share_a = static_cast<double>(i) - 1.0;
    double share_b = static_cast<double>(i);
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = 0.5 * (share_a + share_b);
      const NearestFacet c = find(middle);
      if (!c.is_found) break;
      const bool is_past = !IsSameFace(c, a) && (IsSameFace(c, b) || MeetInAConvexEdge(a, c));
      (is_past ? b : a) = c;
      (is_past ? share_b : share_a) = middle;
    }
    const glm::dvec3 e = glm::cross(a.normal, b.normal);
    const glm::dvec3 across = glm::cross(along, e);
    if (IsSameFace(a, b) || !MeetInAConvexEdge(a, b) || glm::dot(across, across) < kParallel * glm::dot(e, e)) continue;
    // A point of G's edge: q = p + (ha (b x e) + hb (e x a)) / e^2 with the planes' heights over p.
    const double ha = glm::dot(a.place - p, a.normal);
    const double hb = glm::dot(b.place - p, b.normal);
    const glm::dvec3 from_p = (ha * glm::cross(b.normal, e) + hb * glm::cross(e, a.normal)) / glm::dot(e, e);
    const double t = glm::dot(glm::cross(from_p, e), across) / glm::dot(across, across);
    glm::dvec3 n = across / glm::length(across);
    if (glm::dot(n, inward_G) < 0.0) n = -n;
    const bool is_between = glm::dot(glm::cross(a.normal, n), e) >= 0.0 && glm::dot(glm::cross(n, b.normal), e) >= 0.0;
    if (std::abs(t) > reach + kClear || !is_between) continue;
    const double height = glm::dot(t * along - from_p, n);
    if (least.gap.is_found && height >= least.gap.height) continue;
    least = {{true, p + t * along, n, height}, glm::dot(a.normal, n) > glm::dot(b.normal, n) ? a : b};
  }
  return least;
}

// From a place on a triangle straight up it, to its rim.
glm::dvec3 UpToRim(const NearestFacet& facet, const glm::dvec3& up) {
  const glm::dvec3 d = up - glm::dot(up, facet.normal) * facet.normal;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3& a = facet.corners[k];
    const glm::dvec3 out = glm::cross(facet.corners[(k + 1) % 3] - a, facet.normal);
    const double speed = glm::dot(d, out);
    if (speed > 0.0) least = std::min(least, std::max(glm::dot(a - facet.place, out), 0.0) / speed);
  }
  return std::isfinite(least) ? facet.place + least * d : facet.place;
}

// A flat patch of S over G. It slides over G's faces to the edge or the corner that is right below, as far as the patch
// reaches and `is_on_S` holds: that touches first, and the normal is S's own. Up a wall it slides only where S goes on
// inside the wall: a needle that stands in a plate is felt, the wall along a peg that ends there is not under it.
template <class IsOnS>
Gap OverPatch(const FacetsAround& around, double reach, const glm::dvec3& p, const glm::dvec3& inward_G, double depth,
              const IsOnS& is_on_S) {
  double back = std::max(depth, 0.0) + kClear;
  glm::dvec3 way(0.0);
  glm::dvec3 inside(0.0);
  Gap gap;
  for (int hop = 0; hop < kMostHops; ++hop) {
    const NearestFacet facet = around.FindNearest(p + way + back * inward_G, back + reach + ReachOf(depth));
    if (!facet.is_found) return gap;
    const glm::dvec3 above = p + way + back * inward_G - facet.place;
    const bool is_right_above =
        facet.height > 0.0 && glm::dot(above, inward_G) > (1.0 - 0.5 * kSlope * kSlope) * glm::length(above);
    if (hop == 0 || (is_right_above && is_on_S(p + way + inside))) {
      gap = {true, p + way, facet.normal, 0.0};
      if (is_right_above && !facet.is_on_face) {
        gap.n = inward_G;
      } else if (!facet.is_on_face && std::abs(facet.height) > 0.25 * kClear) {
        gap.n = above / facet.height;
      }
      gap.height = glm::dot(gap.p - facet.place, gap.n);
    }
    const double rise = glm::dot(facet.normal, inward_G);
    if (is_right_above || rise < -kSlope) return gap;
    if (rise <= kSlope) inside = -2.0 * kClear * facet.normal;
    glm::dvec3 to = facet.is_on_face ? UpToRim(facet, inward_G) : facet.corners[0];
    for (const glm::dvec3& corner : facet.corners) {
      if (!facet.is_on_face && glm::dot(corner - to, inward_G) > 0.0) to = corner;
    }
    way = to - p;
    const double up = glm::dot(way, inward_G);
    back = std::max(up, 0.0) + kClear;
    way -= up * inward_G;
    if (glm::length(way) > reach) return gap;
  }
  return gap;
}

// Distinct corners of one surface hardly ever have the same name; if two do, they take turns in one slot.
std::uint32_t NameOf(const glm::dvec3& corner) {
  const glm::ivec3 steps(glm::round(corner / static_cast<double>(kFacetStep)));
  const auto hash = static_cast<std::uint32_t>(steps.x) * 73856093U ^ static_cast<std::uint32_t>(steps.y) * 19349663U ^
                    static_cast<std::uint32_t>(steps.z) * 83492791U;
  return hash | kCornerOfG;
}

// A corner of G over a face of S, seen from a point that is clear of S's surface. The normal is that face's.
Gap UnderFace(const SurfacePieces& pieces, const DistanceField& field, const core::Pose& X_GS,
              const Below::Corner& corner, double spacing) {
  const double voxel_m = field.voxel_size_m;
  const double back = ReachOf(std::min(corner.height, 0.0));
  glm::dvec3 n = corner.n;
  for (int turn = 0; turn < kMostHops; ++turn) {
    const glm::dvec3 from_S = X_GS.inverse() * ((corner.p - back * n) * voxel_m + field.origin_m);
    const NearestPiece piece = FindNearestPiece(pieces, from_S, (2.0 * back + spacing) * voxel_m);
    if (!piece.is_found) return {};
    const glm::dvec3 before = n;
    n = -X_GS.rotate(piece.outward);
    if (glm::dot(n, before) < 1.0 - 0.5 * kSlope * kSlope) continue;
    if (!piece.is_on_face) return {};
    const glm::dvec3 p = (X_GS * piece.place - field.origin_m) / voxel_m;
    const double height = glm::dot(p - corner.p, n);
    return {true, corner.p + height * n, n, height};
  }
  return {};
}

// By which the gap can fall along S away from its place.
double Slope(const TouchPlace& place, const glm::dvec3& n, const glm::dvec3& inward_G, const glm::dvec3& along_G) {
  if (place.kind == TouchPlace::Kind::kEdge) return std::abs(glm::dot(n, along_G));
  return place.kind == TouchPlace::Kind::kFace ? glm::length(glm::cross(n, inward_G)) : 0.0;
}

// The gaps of a place of S. It is seen from a point that is clear of the surface, back along S's own normal.
Gaps Query::ByFacets(const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along_G,
                     const glm::dvec3& inward_G, double depth, Below* below) {
  const double reach = static_cast<double>(place.reach_m) / field.voxel_size_m;
  const double back = std::max(depth, 0.0) + kClear;
  const double around_place = back + ReachOf(depth);
  const glm::dvec3 from = p + back * inward_G;
  Gaps gaps;
  NearestFacet face;
  if (place.kind == TouchPlace::Kind::kFace) {
    around.Gather(field.triangles(), p, 2.0 * reach + around_place);
    gaps.least =
        OverPatch(around, reach, p, inward_G, depth, [&](const glm::dvec3& at) { return IsOnS(at, inward_G); });
    face = around.FindNearest(from, around_place);
  } else {
    NearestFacet facet;
    if (place.kind == TouchPlace::Kind::kEdge) {
      around.Gather(field.triangles(), p, 2.0 * kOverlap * reach + back + around_place);
      const Crossing crossing = OverEdge(around, reach, p, along_G, inward_G, depth);
      facet = around.FindNearest(from, around_place);
      gaps.least = crossing.gap;
      face = crossing.gap.is_found ? crossing.face : facet;
    } else {
      around.Gather(field.triangles(), p, back + around_place);
      face = facet = around.FindNearest(from, around_place);
    }
    if (!facet.is_found) return gaps;
    if (!gaps.least.is_found) {
      gaps.least = {true, p, facet.normal, 0.0};
      if (!facet.is_on_face && std::abs(facet.height) > 0.25 * kClear) {
        gaps.least.n = (from - facet.place) / facet.height;
      }
      gaps.least.height = glm::dot(p - facet.place, gaps.least.n);
    }
    if (gaps.least.height < kExactWithin) {
      below->Add(facet, gaps.least.p, gaps.least.n, gaps.least.height,
                 kAroundCorner * S.spacing_m / field.voxel_size_m);
    }
  }
  if (gaps.least.is_found && face.is_found && gaps.least.height < kExactWithin) {
    gaps.other = OverOtherFace(place, p, along_G, inward_G, depth, gaps.least, face);
  }
  return gaps;
}

// Of a place in a groove of G, from the other face than `face`. In a groove each of the two is above the other's plane:
// the far side of a thin wall, and what is behind it, are not.
Gap Query::OverOtherFace(const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along_G,
                         const glm::dvec3& inward_G, double depth, const Gap& least, const NearestFacet& face) {
  constexpr double kOnPlane = static_cast<double>(kFacetStep);  // corners are rounded
  around.LeaveOut(face);
  const double back = std::max(depth, 0.0) + kClear;
  Gap gap;
  if (place.kind == TouchPlace::Kind::kEdge) {
    const double reach = static_cast<double>(place.reach_m) / field.voxel_size_m;
    gap = OverEdge(around, reach, p, along_G, inward_G, depth).gap;
  }
  if (!gap.is_found) {
    const NearestFacet other = around.FindNearest(p + back * inward_G, back + ReachOf(depth));
    if (!other.is_found || !other.is_on_face) return {};
    gap = {true, p, other.normal, glm::dot(p - other.place, other.normal)};
  }
  const glm::dvec3 across = gap.OnG() - least.OnG();
  const glm::dvec3 turn = glm::cross(gap.n, least.n);
  gap.is_found =
      glm::dot(turn, turn) > kSameFace && glm::dot(across, least.n) > -kOnPlane && glm::dot(across, gap.n) < kOnPlane;
  return gap;
}

// Of a place in the plane of one of S's faces.
bool Query::IsOnS(const glm::dvec3& p, const glm::dvec3& inward_G) const {
  if (S.pieces.pieces.empty()) return true;
  const glm::dvec3 outside = X_GS.inverse() * ((p - kClear * inward_G) * field.voxel_size_m + field.origin_m);
  return FindNearestPiece(S.pieces, outside, 1.01 * kClear * field.voxel_size_m).is_found;
}

// A place stands for the round surface around it, whose faces take turns within a cycle: a normal that is farther
// outside its own than from one face to the next belongs to another place.
double Query::Beside() const {
  return S.turn_rad + kSlope;
}

Gaps Query::Measure(std::uint32_t point, double depth, Below* below) {
  const TouchPlace& place = S.places[point];
  const glm::dvec3 p = InVoxels(PointAt(point));
  const glm::dvec3 inward_G = X_GS.rotate(glm::dvec3(place.inward));
  const glm::dvec3 along_G = X_GS.rotate(glm::dvec3(place.along));
  Gaps gaps{ByField(field, p), {}};
  double beside = kBesideByField;
  if (gaps.least.height -
          Slope(place, gaps.least.n, inward_G, along_G) * static_cast<double>(place.reach_m) / field.voxel_size_m <
      kExactWithin) {
    const Gaps exact = ByFacets(place, p, along_G, inward_G, depth, below);
    if (exact.least.is_found) {
      gaps = exact;
      beside = Beside();
    }
  }
  // Else it cannot be what touches there: S reaches farther beside it, or G ends before.
  const auto belongs = [&](const Gap& gap) {
    const double off = std::atan2(glm::length(glm::cross(gap.n, inward_G)), glm::dot(gap.n, inward_G));
    return off < static_cast<double>(place.cone_rad) + beside;
  };
  gaps.least.is_found = belongs(gaps.least);
  gaps.other.is_found = gaps.other.is_found && belongs(gaps.other);
  if (!gaps.least.is_found) std::swap(gaps.least, gaps.other);
  return gaps;
}

Gaps Query::GapsOf(std::uint32_t point, double depth, Below* below) {
  const Measured* const known = Find(point);
  return known != nullptr ? known->gaps : Measure(point, depth, below);
}

// The nearest of each bin is the one with the least exact gap of those that can have it.
void Query::MeasureNearest(Below* below) {
  for (Bin& bin : bins) {
    double least = std::numeric_limits<double>::infinity();
    for (const Likely& one : bin.likely) {
      const double bound = -static_cast<double>(one.depth) - kDoubt;
      if (bound >= std::min(least, kExactWithin)) break;
      const Gaps gaps = Measure(one.point, static_cast<double>(DepthOf(one.point)), below);
      measured.push_back({one.point, gaps, {}});
      if (!gaps.least.is_found || gaps.least.height >= least) continue;
      least = gaps.least.height;
      bin.nearest = one.point;
      bin.nearest_depth = -static_cast<float>(least);
    }
  }
}

bool IsNear(const FacetsAround::Facet& facet, const glm::dvec3& p, double reach) {
  const glm::dvec3 a = facet.corners[0] - p;
  const glm::dvec3 b = facet.corners[1] - p;
  const glm::dvec3 c = facet.corners[2] - p;
  const glm::dvec3 q = NearestOnTriangle(a, b, c, glm::cross(b - a, c - a)).place;
  return glm::dot(q, q) < reach * reach;
}

// The direction next to n in which G's corner can carry: all of G around it lies on or below the plane across it. On a
// flat part of G that is the face's normal, on a straight edge it is across the edge. Each way up is projected off, and
// the passes repeat because one projection may raise another way.
glm::dvec3 Query::Carrying(const glm::dvec3& corner, glm::dvec3 n) {
  constexpr double kStep = 2.0 * static_cast<double>(kFacetStep);  // corners are rounded
  around.Gather(field.triangles(), corner, kStep);
  for (int pass = 0; pass < kMostHops; ++pass) {
    for (const FacetsAround::Facet& facet : around.facets()) {
      if (!IsNear(facet, corner, kStep)) continue;
      for (const glm::dvec3& other : facet.corners) {
        const glm::dvec3 way = other - corner;
        const double length = glm::length(way);
        const double up = glm::dot(way, n);
        if (up > kStep + kSlope * length) n = glm::normalize(n - up / (length * length) * way);
      }
    }
  }
  return n;
}

void Query::MeasureCorners(const Below& below) {
  const double spacing = S.spacing_m / field.voxel_size_m;
  for (const Below::Corner& corner : below.corners) {
    Gap gap = UnderFace(S.pieces, field, X_GS, corner, spacing);
    if (!gap.is_found || gap.height >= kExactWithin) continue;
    const glm::dvec3 n = Carrying(corner.p, gap.n);
    const double cosine = glm::dot(n, gap.n);
    if (cosine < std::cos(Beside())) continue;
    gap.height /= cosine;  // to the plane of S's face, along n
    gap.n = n;
    gap.p = corner.p + gap.height * n;
    measured.push_back({NameOf(corner.p), {gap, {}}, corner.p});
  }
}

// Which of the slot's two faces the least gap is from: those of the last cycle keep their ids.
std::size_t FaceOf(const Gaps& gaps, const GapPlanes::Slot& slot) {
  double as_0 = glm::dot(gaps.least.n, slot.n[0]);
  double as_1 = glm::dot(gaps.least.n, slot.n[1]);
  if (gaps.other.is_found) {
    as_0 += glm::dot(gaps.other.n, slot.n[1]);
    as_1 += glm::dot(gaps.other.n, slot.n[0]);
  }
  return as_1 > as_0 ? 1 : 0;
}

// As the guards of ReducePatches: together they have the pair's stiffness.
void TakeNearest(const core::Pose& X_GS, const PairDescription& pair, const GapPlanes& gaps,
                 core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>* planes) {
  std::array<std::pair<double, std::size_t>, kMaxGapPlanes> order;
  for (std::size_t i = 0; i < gaps.planes.size(); ++i) {
    const core::ContactPlane& plane = gaps.planes[i];
    const glm::dvec3 n_G(plane.n_G);
    order[i] = {glm::dot(n_G, X_GS * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G)), i};
  }
  std::sort(order.begin(), order.begin() + gaps.planes.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < std::min(gaps.planes.size(), core::kMaxContactPlanes); ++i) {
    core::ContactPlane plane = gaps.planes[order[i].second];
    const double share = std::clamp(1.0 - order[i].first / (0.25 * pair.look_ahead_m + 1e-9), kLeastShare, 1.0);
    sum += share;
    plane.stiffness_N_per_m *= static_cast<float>(share);
    planes->push_back(plane);
  }
  for (core::ContactPlane& plane : *planes) plane.stiffness_N_per_m /= static_cast<float>(sum);
}

}  // namespace

double FinishGapPair(const TouchPoints& S, const DistanceField& field, const core::Pose& X_WS, const core::Pose& X_GS,
                     const PairDescription& pair, double rho, FastPairScratch* scratch, GapPlanes* gaps,
                     PairResult* result) {
  const FieldWalkResult& walk = scratch->levels.result();
  result->counters = {walk.spheres_tested, walk.points_tested, walk.num_colliding};
  gaps->planes.clear();
  result->planes.clear();
  scratch->force_m3 = walk.force_m3;
  scratch->moment_m4 = walk.moment_m4;
  if (walk.num_near == 0) {
    gaps->Clear();
    result->is_in_contact = false;
    result->f_So_S = {};
    result->F_So_W = {};
    result->signed_distance_m = std::max(0.0, pair.look_ahead_m + walk.free_distance_m - S.tree.reach_m);
    return walk.free_distance_m;
  }
  const double voxel_m = field.voxel_size_m;
  Query query{S,
              field,
              X_GS,
              scratch->walk,
              walk,
              static_cast<float>(pair.look_ahead_m / voxel_m),
              glm::mat3(glm::mat3_cast(X_GS.rotation)),
              glm::mat3_cast(X_GS.rotation) / voxel_m,
              (X_GS.translation - field.origin_m) / voxel_m,
              {},
              {},
              {},
              {}};
  query.FillBins();
  Below below;
  for (const GapPlanes::Slot& slot : gaps->slots) {
    if (slot.cycles_left >= 0 && (slot.point & kCornerOfG) != 0) below.corners.push_back({slot.corner, slot.n[0], 0.0});
  }
  query.MeasureNearest(&below);
  query.MeasureCorners(below);
  query.Choose(gaps);

  double least_m = std::numeric_limits<double>::infinity();
  const auto add = [&](const Gap& gap, std::uint32_t id) {
    core::ContactPlane plane;
    plane.id = id;
    const glm::dvec3 p_G = gap.p * voxel_m + field.origin_m;
    plane.p_S = glm::vec3(X_GS.inverse() * p_G);
    plane.n_G = glm::vec3(gap.n);
    plane.q_G = glm::vec3(p_G - gap.height * voxel_m * gap.n);
    plane.stiffness_N_per_m = static_cast<float>(pair.stiffness_N_per_m);
    gaps->planes.push_back(plane);
    if (gap.height * voxel_m >= least_m) return;
    least_m = gap.height * voxel_m;
    result->deepest_p_S = glm::dvec3(plane.p_S);
    result->deepest_n_S = glm::conjugate(X_GS.rotation) * gap.n;
  };
  std::size_t num_others = 0;
  for (const Candidate& candidate : query.candidates) {
    Gaps found = query.GapsOf(candidate.point, static_cast<double>(candidate.depth), &below);
    if (!found.least.is_found) continue;  // the side that faces away
    found.other.is_found = found.other.is_found && num_others < kMaxOtherFaces;
    const auto slot = static_cast<std::size_t>(candidate.slot);
    const std::size_t face = FaceOf(found, gaps->slots[slot]);
    add(found.least, GapPlanes::IdOf(slot, face));
    gaps->slots[slot].n[face] = found.least.n;
    if (!found.other.is_found) continue;
    ++num_others;
    add(found.other, GapPlanes::IdOf(slot, 1 - face));
    gaps->slots[slot].n[1 - face] = found.other.n;
  }
  result->signed_distance_m = std::min(least_m, pair.look_ahead_m);
  result->is_in_contact = least_m < 0.0;
  const double scale = AreaScale(walk.volume_m3, walk.square_m4, S.tree.area_m2, rho);
  result->f_So_S = scale * PenetrationSum{walk.force_m3, walk.moment_m4};
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));
  TakeNearest(X_GS, pair, *gaps, &result->planes);
  return 0.0;
}

}  // namespace vps
