#include "vps/multibody/gap_query.hpp"

#include <algorithm>
#include <limits>

#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/gap/choose_places.hpp"
#include "vps/multibody/gap/place_gap.hpp"

namespace vps {
namespace {

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
    const double share = GuardShare(-order[i].first, pair.look_ahead_m);
    sum += share;
    plane.stiffness_N_per_m *= static_cast<float>(share);
    planes->push_back(plane);
  }
  for (core::ContactPlane& plane : *planes) plane.stiffness_N_per_m /= static_cast<float>(sum);
}

// Finds the places that matter, and measures them.
struct GapQuery {
  const GapScene& scene;
  NearPlaces near;
  GapScratch& now;

  Gaps Measure(std::uint32_t point, double depth) { return MeasurePlace(scene, point, depth, &now.around, &now.below); }
  Gaps GapsOf(const GapCandidate& candidate) {
    if (IsCornerOfG(candidate.point)) return {FindCorner(now.corners, candidate.point)->gap, {}};
    for (const TouchBin::Measured& known : now.bins[TouchBinOf(scene.S.places[candidate.point])].measured) {
      if (known.point == candidate.point) return known.gaps;
    }
    return Measure(candidate.point, static_cast<double>(candidate.depth));
  }
  // Corners of G that had a plane in the last cycle.
  void TakeCorners(const GapPlanes& gaps) {
    now.below.corners.clear();
    for (const GapPlanes::Slot& slot : gaps.slots) {
      if (slot.cycles_left >= 0 && IsCornerOfG(slot.point)) now.below.corners.push_back({slot.corner, slot.n[0], 0.0});
    }
  }
  // The nearest of each bin is the one with the least exact gap of those that can have it.
  void MeasureNearest() {
    for (TouchBin& bin : now.bins) {
      double least = std::numeric_limits<double>::infinity();
      for (const TouchBin::Likely& one : bin.likely) {
        const double bound = -static_cast<double>(one.depth) - static_cast<double>(kUsualFieldError);
        if (bound >= std::min(least, kExactWithin)) break;
        const Gaps gaps = Measure(one.point, static_cast<double>(near.DepthOf(one.point)));
        bin.measured.push_back({one.point, gaps});
        if (!gaps.least.is_found || gaps.least.height >= least) continue;
        least = gaps.least.height;
        bin.nearest = one.point;
        bin.nearest_depth = -static_cast<float>(least);
      }
    }
  }
  void MeasureCorners() {
    now.corners.clear();
    for (const CornersBelow::Corner& corner : now.below.corners) {
      const Gap gap = MeasureCorner(scene, corner, &now.around);
      if (gap.is_found) now.corners.push_back({NameOfCorner(corner.p), corner.p, gap});
    }
  }
};

// Planes of gaps, and the least of them.
class PlaneWriter {
 public:
  PlaneWriter(const GapScene& scene, double stiffness_N_per_m, GapPlanes* gaps)
      : scene_(scene), stiffness_N_per_m_(static_cast<float>(stiffness_N_per_m)), gaps_(*gaps) {}

  void Add(Gaps found, std::size_t s) {
    found.other.is_found = found.other.is_found && num_others_ < kMaxOtherFaces;
    const std::size_t face = FaceOf(found, gaps_.slots[s]);
    Add(found.least, s, face);
    if (!found.other.is_found) return;
    ++num_others_;
    Add(found.other, s, 1 - face);
  }
  [[nodiscard]] double least_m() const { return least_m_; }

 private:
  void Add(const Gap& gap, std::size_t s, std::size_t face) {
    gaps_.slots[s].n[face] = gap.n;
    const double voxel_m = scene_.field.voxel_size_m;
    core::ContactPlane plane;
    plane.id = GapPlanes::IdOf(s, face);
    const glm::dvec3 p_G = gap.p * voxel_m + scene_.field.origin_m;
    plane.p_S = glm::vec3(scene_.X_GS.inverse() * p_G);
    plane.n_G = glm::vec3(gap.n);
    plane.q_G = glm::vec3(p_G - gap.height * voxel_m * gap.n);
    plane.stiffness_N_per_m = stiffness_N_per_m_;
    gaps_.planes.push_back(plane);
    least_m_ = std::min(least_m_, gap.height * voxel_m);
  }

  const GapScene& scene_;
  const float stiffness_N_per_m_;
  GapPlanes& gaps_;
  std::size_t num_others_ = 0;
  double least_m_ = std::numeric_limits<double>::infinity();
};

// Replaces the planes; returns the least gap.
double MeasurePlanes(const GapScene& scene, const PairDescription& pair, const FastPairScratch& scratch,
                     GapScratch* now, GapPlanes* gaps) {
  const auto margin = static_cast<float>(WalkMargin_m(scene.S.tree, pair.look_ahead_m) / scene.field.voxel_size_m);
  GapQuery query{scene, {scene.S, scratch.walk, scratch.found, margin}, *now};
  FillBins(scene, query.near, &now->bins);
  query.TakeCorners(*gaps);
  query.MeasureNearest();
  query.MeasureCorners();
  ChoosePlaces(scene, query.near, gaps, now);
  PlaneWriter writer(scene, pair.stiffness_N_per_m, gaps);
  for (const GapCandidate& candidate : now->candidates) {
    const Gaps found = query.GapsOf(candidate);
    if (found.least.is_found) writer.Add(found, static_cast<std::size_t>(candidate.slot));  // else it faces away
  }
  return writer.least_m();
}

}  // namespace

double FinishGapPair(const FastPair& parts, const TouchPoints& touch, const core::Pose& X_WS, const core::Pose& X_GS,
                     const PairDescription& pair, double rho, FastPairScratch* scratch, GapPlanes* gaps,
                     PairResult* result) {
  const FieldWalkResult& walk = scratch->found;
  result->counters = {walk.spheres_tested, walk.points_tested, walk.num_colliding};
  if (walk.num_near == 0) {
    gaps->Clear();
    return SetApart(walk.free_distance_m, WalkMargin_m(touch.tree, pair.look_ahead_m), touch.tree, scratch, result);
  }
  gaps->planes.clear();
  result->planes.clear();
  ClearTouch(scratch, result);
  const double least_m = MeasurePlanes(GapScene(touch, parts.field, X_GS), pair, *scratch, scratch->gaps.get(), gaps);
  result->signed_distance_m = std::min(least_m, pair.look_ahead_m);
  result->is_in_contact = least_m < 0.0;
  if (result->is_in_contact) IntegrateTouch(parts, X_WS, X_GS, pair, rho, scratch, result);
  TakeNearest(X_GS, pair, *gaps, &result->planes);
  return 0.0;
}

}  // namespace vps
