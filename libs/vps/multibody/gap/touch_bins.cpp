#include "vps/multibody/gap/touch_bins.hpp"

#include <algorithm>
#include <cmath>

#include "vps/field/four_lanes.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kSpread = 16;  // not derived

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

// What is added to four lanes to leave only those whose bit is set.
F4 OnlyLanes(unsigned bits) {
  const I4 is_set = (I4{1, 2, 4, 8} & static_cast<std::int32_t>(bits)) != 0;
  return is_set ? F4{} : F4{} - std::numeric_limits<float>::infinity();
}
float MostOf(F4 four) {
  return std::max(std::max(four[0], four[1]), std::max(four[2], four[3]));
}

float DeepestOf(const float* depths, unsigned lanes) {
  F4 most = Load4(depths) + OnlyLanes(lanes);
  for (unsigned k = 4; k < kBlock; k += 4) most = Max4(most, Load4(depths + k) + OnlyLanes(lanes >> k));
  return MostOf(most);
}

// Those of the group that are farther out than the ones that the bin has. Mostly there are none, which is found for all
// lanes at once.
void FindOuter(const NearPlaces& near, const TouchGroup& group, std::uint32_t block, TouchBin* bin) {
  if (bin->nearest == kNoPlace) return;
  const auto& [tangent_u, tangent_v] = BinTangents(group.bin);
  const std::uint32_t first = near.walk.near_blocks[block] * kBlock;
  const PointBlock& points = near.S.tree.points[first / kBlock];
  const float* const depths = near.walk.depths(block);
  std::array<F4, kBlock / 4> u, v;
  F4 farther = OnlyLanes(0);
  for (std::uint32_t i = 0; i < kBlock / 4; ++i) {
    const F4 x = Load4(points.x + 4 * i) - bin->p.x;
    const F4 y = Load4(points.y + 4 * i) - bin->p.y;
    const F4 z = Load4(points.z + 4 * i) - bin->p.z;
    const F4 weight = 1.0f - (bin->nearest_depth - Load4(depths + 4 * i)) / near.margin;
    u[i] = weight * (x * tangent_u.x + y * tangent_u.y + z * tangent_u.z);
    v[i] = weight * (x * tangent_v.x + y * tangent_v.y + z * tangent_v.z);
    const F4 most =
        Max4(Max4(u[i] - bin->merits[0], v[i] - bin->merits[1]), Max4(-u[i] - bin->merits[2], -v[i] - bin->merits[3]));
    farther = Max4(farther, most + OnlyLanes(group.lanes >> 4 * i));
  }
  if (MostOf(farther) <= 0.0f) return;
  near.ForEachNear(group.lanes, block, [&](std::uint32_t point, float depth) {
    const std::uint32_t k = point - first;
    const std::array<float, 4> merits{u[k / 4][k % 4], v[k / 4][k % 4], -u[k / 4][k % 4], -v[k / 4][k % 4]};
    for (std::size_t side = 0; side < 4; ++side) {
      if (merits[side] <= bin->merits[side]) continue;
      bin->merits[side] = merits[side];
      bin->outer[side] = point;
      bin->depths[side] = depth;
    }
  });
}

// Blocks next to each other follow each other: after some from everywhere few are farther out than those before.
void FindOuters(const NearPlaces& near, TouchBins* bins) {
  const auto find = [&](const TouchGroup& group, std::uint32_t block) {
    FindOuter(near, group, block, &(*bins)[TouchBinOf(group)]);
  };
  for (std::uint32_t i = 0; i < near.result.num_near_blocks; i += kSpread) near.ForEachGroup(i, find);
  for (std::uint32_t i = 0; i < near.result.num_near_blocks; ++i) {
    if (i % kSpread != 0) near.ForEachGroup(i, find);
  }
}

// Over an edge or a corner of G the gap falls along S away from its place, but no faster than there.
float MostDepth(const GapScene& scene, std::uint32_t point, float depth) {
  const TouchPlace& place = scene.S.places[point];
  if (place.kind == TouchPlace::Kind::kCorner) return depth;
  const glm::vec3 n = SampleField(scene.field, glm::vec3(scene.InVoxels(scene.PointAt(point)))).gradient;
  const float slope = place.kind == TouchPlace::Kind::kEdge ? std::abs(glm::dot(n, scene.R_GS * place.along))
                                                            : glm::length(glm::cross(n, scene.R_GS * place.inward));
  return depth + slope * place.reach_m / static_cast<float>(scene.field.voxel_size_m);
}

// In the order of the places, so that of equally likely ones the same is the first whichever block is deepest.
void FindLikely(const GapScene& scene, const NearPlaces& near, TouchBin* bin) {
  std::sort(bin->deep.begin(), bin->deep.end(),
            [](const TouchBin::DeepGroup& a, const TouchBin::DeepGroup& b) { return a.near < b.near; });
  for (const TouchBin::DeepGroup& group : bin->deep) {
    near.ForEachNear(group.lanes, group.near, [&](std::uint32_t point, float depth) {
      const float most = depth + near.S.places[point].reach_m / static_cast<float>(scene.field.voxel_size_m);
      if (most <= -kLikelyWithin) return;
      if (bin->likely.full() && bin->likely.back().depth >= most) return;
      OfferByDepth({point, MostDepth(scene, point, depth)}, &bin->likely);
    });
  }
}

void FindDeepest(const GapScene& scene, const NearPlaces& near, TouchBins* bins) {
  const float within = kLikelyWithin + static_cast<float>(near.S.most_reach_m / scene.field.voxel_size_m);
  const auto find = [&](const TouchGroup& group, std::uint32_t block) {
    const float* const depths = near.walk.depths(block);
    const float deepest = DeepestOf(depths, group.lanes);
    if (!(deepest >= -near.margin)) return;
    TouchBin& bin = (*bins)[TouchBinOf(group)];
    if (deepest > -within) OfferByDepth({deepest, block, group.lanes}, &bin.deep);
    if (deepest <= bin.nearest_depth) return;
    std::uint32_t at = 0;
    while ((group.lanes >> at & 1U) == 0 || depths[at] != deepest) ++at;
    bin.nearest_depth = deepest;
    bin.nearest = near.walk.near_blocks[block] * kBlock + at;
  };
  for (std::uint32_t i = 0; i < near.result.num_near_blocks; ++i) near.ForEachGroup(i, find);
}

}  // namespace

void FillBins(const GapScene& scene, const NearPlaces& near, TouchBins* bins) {
  for (TouchBin& bin : *bins) bin.Clear();
  FindDeepest(scene, near, bins);
  for (TouchBin& bin : *bins) {
    if (bin.nearest == kNoPlace) continue;
    bin.p = scene.PointAt(bin.nearest);
    FindLikely(scene, near, &bin);
  }
  FindOuters(near, bins);
}

}  // namespace vps
