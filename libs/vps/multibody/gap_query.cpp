#include "vps/multibody/gap_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/field/nearest_facet.hpp"
#include "vps/force/direction_bins.hpp"
#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
// Faces, edges and corners of each direction: of two that are equally near none stands for the other.
constexpr std::size_t kNumBins = 3 * kNumDirectionBins;
constexpr float kFar = std::numeric_limits<float>::infinity();
// Cycles for which a place keeps its plane after others have become nearer: longer than a contact fades.
constexpr std::int8_t kStay = 8;
// A place gets its exact gap when it can be nearer than this by the field [voxels]: beyond, what the field is
// off by does not matter before the next cycle.
constexpr double kExactWithin = 0.5;
// From a point this much off the surface it is clear which face, edge or corner of G is below [voxels].
constexpr double kClear = 0.02;
constexpr double kSlope = 1e-3;  // faces with less between them are along each other
constexpr int kMostHops = 5;
constexpr int kHalvings = 4;  // of the way between two places above different faces, to find those that are neighbours
constexpr double kLeastShare = 0.05;  // of the stiffness, of a plane far away: as ReducePatches
// Faces whose normals differ by less are one, edges that do are parallel: sines, squared.
constexpr double kSameFace = 1e-4;
constexpr double kParallel = 1e-6;

// A direction of S's surface: its nearest place, and those that are far from it on four sides without being much
// farther away.
struct Bin {
  std::uint32_t nearest = kNone;
  float nearest_depth = -kFar;  // voxels
  glm::vec3 p{0.0f};
  std::array<std::uint32_t, 4> outer{kNone, kNone, kNone, kNone};
  std::array<float, 4> merits{};
  std::array<float, 4> depths{};
};

struct Candidate {
  std::uint32_t point = 0;
  float depth = 0.0f;  // voxels
  bool is_first = false;
  std::int8_t slot = -1;
};

struct Query {
  const TouchPoints& S;
  const DistanceField& field;
  const core::Pose& X_GS;
  const FieldWalkScratch& walk;
  const FieldWalkResult& result;
  float margin;  // voxels
  std::array<Bin, kNumBins> bins;
  core::FixedVector<Candidate, 5 * kNumBins + kMaxGapPlanes> candidates;

  template <class Take>
  void ForEachNear(const Take& take) const {
    for (std::uint32_t i = 0; i < result.num_near_blocks; ++i) {
      const std::uint32_t first = walk.near_blocks[i] * kBlock;
      const float* const depths = walk.depths(i);
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (depths[k] >= -margin) take(first + k, depths[k]);
      }
    }
  }
  [[nodiscard]] glm::vec3 PointAt(std::uint32_t point) const {
    return PointOf(S.tree.points[point / kBlock], point % kBlock);
  }
  [[nodiscard]] float DepthOf(std::uint32_t point) const {
    const auto begin = walk.near_blocks.begin();
    const auto end = begin + result.num_near_blocks;
    const auto at = std::lower_bound(begin, end, point / kBlock);
    if (at == end || *at != point / kBlock) return -kFar;
    return walk.depths(static_cast<std::uint32_t>(at - begin))[point % kBlock];
  }

  static std::size_t BinOf(const TouchPlace& place) {
    return static_cast<std::size_t>(place.kind) * kNumDirectionBins + place.bin;
  }
  void FillBins() {
    ForEachNear([&](std::uint32_t point, float depth) {
      Bin& bin = bins[BinOf(S.places[point])];
      if (depth <= bin.nearest_depth) return;
      bin.nearest_depth = depth;
      bin.nearest = point;
    });
    for (Bin& bin : bins) {
      if (bin.nearest != kNone) bin.p = PointAt(bin.nearest);
    }
    ForEachNear([&](std::uint32_t point, float depth) {
      Bin& bin = bins[BinOf(S.places[point])];
      const Tangents& tangents = BinTangents(S.places[point].bin);
      const glm::vec3 r = PointAt(point) - bin.p;
      const float weight = 1.0f - (bin.nearest_depth - depth) / margin;
      const float u = weight * glm::dot(r, tangents.u);
      const float v = weight * glm::dot(r, tangents.v);
      const std::array<float, 4> merits{u, v, -u, -v};
      for (std::size_t k = 0; k < 4; ++k) {
        if (merits[k] <= bin.merits[k]) continue;
        bin.merits[k] = merits[k];
        bin.outer[k] = point;
        bin.depths[k] = depth;
      }
    });
  }

  void Offer(const Candidate& candidate) {
    for (Candidate& known : candidates) {
      if (known.point != candidate.point) continue;
      known.is_first = known.is_first || candidate.is_first;
      known.slot = std::max(known.slot, candidate.slot);
      return;
    }
    candidates.push_back(candidate);
  }
  // Those of this cycle first, so that these renew the slots of the last ones.
  void Choose(GapPlanes* gaps) {
    for (const Bin& bin : bins) {
      if (bin.nearest != kNone) Offer({bin.nearest, bin.nearest_depth, true});
    }
    for (const Bin& bin : bins) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (bin.outer[k] != kNone) Offer({bin.outer[k], bin.depths[k]});
      }
    }
    for (std::size_t s = 0; s < kMaxGapPlanes; ++s) {
      GapPlanes::Slot& slot = gaps->slots[s];
      if (slot.cycles_left < 0) continue;
      const float depth = DepthOf(slot.point);
      const std::size_t before = candidates.size();
      if (depth >= -margin) Offer({slot.point, depth, false, static_cast<std::int8_t>(s)});
      const bool is_renewed = depth >= -margin && candidates.size() == before;
      slot.cycles_left = static_cast<std::int8_t>(is_renewed ? kStay : slot.cycles_left - 1);
      if (candidates.size() > before && slot.cycles_left < 0) candidates.resize(before);
      if (!(depth >= -margin)) slot.cycles_left = -1;
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      if (a.is_first != b.is_first) return a.is_first;
      return a.depth != b.depth ? a.depth > b.depth : a.point < b.point;
    });
    if (candidates.size() > kMaxGapPlanes) candidates.resize(kMaxGapPlanes);
    // Slots of those that give way are free.
    std::array<bool, kMaxGapPlanes> is_taken{};
    for (const Candidate& c : candidates) {
      if (c.slot >= 0) is_taken[static_cast<std::size_t>(c.slot)] = true;
    }
    std::size_t next = 0;
    for (Candidate& c : candidates) {
      if (c.slot >= 0) continue;
      while (is_taken[next]) ++next;
      is_taken[next] = true;
      c.slot = static_cast<std::int8_t>(next);
      gaps->slots[next] = {c.point, kStay};
    }
    for (std::size_t s = 0; s < kMaxGapPlanes; ++s) {
      if (!is_taken[s]) gaps->slots[s] = {};
    }
  }
};

struct Gap {
  bool is_found = false;
  glm::dvec3 p{0.0};  // of S, in G, voxels
  glm::dvec3 n{0.0};  // from G to S, unit
  double height = 0.0;
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

// Where a piece of a sharp edge of S, along `along`, passes over an edge of G: between two of its places that are above
// different faces of G, whose planes meet in G's edge. The normal is across both edges.
Gap OverEdge(const DistanceField& field, const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along,
             const glm::dvec3& inward_G, double depth) {
  const double reach = static_cast<double>(place.reach_m) / field.voxel_size_m;
  const double back = std::max(depth, 0.0) + kClear;
  const auto find = [&](double share) {
    const glm::dvec3 from = p + share * reach * along + back * inward_G;
    return FindNearestFacet(field.triangles(), from, back + reach + ReachOf(depth));
  };
  const std::array<NearestFacet, 3> below{find(-1.0), find(0.0), find(1.0)};
  Gap least;
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
    if (std::abs(t) > reach || !is_between) continue;
    const double height = glm::dot(t * along - from_p, n);
    if (!least.is_found || height < least.height) least = {true, p + t * along, n, height};
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
// reaches: that touches first, and the normal is S's own.
Gap OverPatch(const DistanceField& field, const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& inward_G,
              double depth) {
  const double reach = static_cast<double>(place.reach_m) / field.voxel_size_m;
  double back = std::max(depth, 0.0) + kClear;
  glm::dvec3 way(0.0);
  Gap gap;
  for (int hop = 0; hop < kMostHops; ++hop) {
    const NearestFacet facet =
        FindNearestFacet(field.triangles(), p + way + back * inward_G, back + reach + ReachOf(depth));
    if (!facet.is_found) return gap;
    const glm::dvec3 above = p + way + back * inward_G - facet.place;
    const bool is_right_above =
        facet.height > 0.0 && glm::dot(above, inward_G) > (1.0 - 0.5 * kSlope * kSlope) * glm::length(above);
    if (hop == 0 || is_right_above) {
      gap = {true, p + way, facet.normal, 0.0};
      if (is_right_above && !facet.is_on_face) {
        gap.n = inward_G;
      } else if (!facet.is_on_face && std::abs(facet.height) > 0.25 * kClear) {
        gap.n = above / facet.height;
      }
      gap.height = glm::dot(gap.p - facet.place, gap.n);
    }
    if (is_right_above || glm::dot(facet.normal, inward_G) <= 0.0) return gap;
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

// The least gap of a place of S. It is seen from a point that is clear of the surface, back along S's own normal.
Gap ByFacets(const DistanceField& field, const TouchPlace& place, const glm::dvec3& p, const glm::dvec3& along,
             const glm::dvec3& inward_G, double depth) {
  if (place.kind == TouchPlace::Kind::kFace) return OverPatch(field, place, p, inward_G, depth);
  if (place.kind == TouchPlace::Kind::kEdge) {
    if (const Gap gap = OverEdge(field, place, p, along, inward_G, depth); gap.is_found) return gap;
  }
  const double back = std::max(depth, 0.0) + kClear;
  const glm::dvec3 from = p + back * inward_G;
  const NearestFacet facet = FindNearestFacet(field.triangles(), from, back + ReachOf(depth));
  if (!facet.is_found) return {};
  Gap gap{true, p, facet.normal, 0.0};
  if (!facet.is_on_face && std::abs(facet.height) > 0.25 * kClear) gap.n = (from - facet.place) / facet.height;
  gap.height = glm::dot(gap.p - facet.place, gap.n);
  return gap;
}

// By which the gap can fall along S away from its place.
double Slope(const TouchPlace& place, const glm::dvec3& n, const glm::dvec3& inward_G, const glm::dvec3& along_G) {
  if (place.kind == TouchPlace::Kind::kEdge) return std::abs(glm::dot(n, along_G));
  return place.kind == TouchPlace::Kind::kFace ? glm::length(glm::cross(n, inward_G)) : 0.0;
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
  Query query{S, field, X_GS, scratch->walk, walk, static_cast<float>(pair.look_ahead_m / voxel_m), {}, {}};
  query.FillBins();
  query.Choose(gaps);

  double least_m = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : query.candidates) {
    const TouchPlace& place = S.places[candidate.point];
    const glm::dvec3 p = (X_GS * glm::dvec3(query.PointAt(candidate.point)) - field.origin_m) / voxel_m;
    const glm::dvec3 inward_G = X_GS.rotate(glm::dvec3(place.inward));
    const glm::dvec3 along_G = X_GS.rotate(glm::dvec3(place.along));
    Gap gap = ByField(field, p);
    if (gap.height - Slope(place, gap.n, inward_G, along_G) * static_cast<double>(place.reach_m) / voxel_m <
        kExactWithin) {
      const Gap exact = ByFacets(field, place, p, along_G, inward_G, static_cast<double>(candidate.depth));
      if (exact.is_found) gap = exact;
    }
    if (gap.height > 0.0 && glm::dot(gap.n, inward_G) <= 0.0) continue;  // the side that faces away
    core::ContactPlane plane;
    plane.id = static_cast<std::uint32_t>(candidate.slot);
    const glm::dvec3 p_G = gap.p * voxel_m + field.origin_m;
    plane.p_S = glm::vec3(X_GS.inverse() * p_G);
    plane.n_G = glm::vec3(gap.n);
    plane.q_G = glm::vec3(p_G - gap.height * voxel_m * gap.n);
    plane.stiffness_N_per_m = static_cast<float>(pair.stiffness_N_per_m);
    gaps->planes.push_back(plane);
    if (gap.height * voxel_m < least_m) {
      least_m = gap.height * voxel_m;
      result->deepest_p_S = glm::dvec3(plane.p_S);
      result->deepest_n_S = glm::conjugate(X_GS.rotation) * gap.n;
    }
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
