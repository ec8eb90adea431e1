#include "vps/multibody/gap/touch_bins.hpp"

#include <algorithm>
#include <cmath>

#include "vps/field/four_lanes.hpp"

namespace vps {
namespace {

constexpr float kPad = 1.0f + 1e-5f;   // against the rounding of floats
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

TouchBin& BinOf(const TouchGroup& group, TouchBins* bins) {
  return (*bins)[static_cast<std::size_t>(group.kind) * kNumDirectionBins + group.bin];
}

// What none of a block's places exceeds at `at`, one way from the bin's nearest place. A place far above the nearest
// one has a negative weight.
float MostMerit(float at, float radius, float below) {
  return std::max(at + radius, below * (radius - at)) * kPad;
}

// By the sphere around a block: whether none of its places is farther out than those that the bin has.
bool HasNoOuter(const NearPlaces& near, std::uint32_t block, const Tangents& tangents, const TouchBin& bin) {
  const SphereBlock& spheres = near.S.tree.spheres[near.S.tree.level_begin[0] + block / kBlock];
  const std::uint32_t j = block % kBlock;
  const glm::vec3 middle = glm::vec3(spheres.x[j], spheres.y[j], spheres.z[j]) - bin.p;
  const float u = glm::dot(middle, tangents.u);
  const float v = glm::dot(middle, tangents.v);
  const float below = std::max(bin.nearest_depth / near.margin, 0.0f);
  const float radius = spheres.r[j] * kPad;
  return MostMerit(u, radius, below) <= bin.merits[0] && MostMerit(v, radius, below) <= bin.merits[1] &&
         MostMerit(-u, radius, below) <= bin.merits[2] && MostMerit(-v, radius, below) <= bin.merits[3];
}

void FindOuter(const GapScene& scene, const NearPlaces& near, const TouchGroup& group, std::uint32_t block,
               TouchBin* bin) {
  if (bin->nearest == kNoPlace) return;
  const Tangents& tangents = BinTangents(group.bin);
  if (HasNoOuter(near, near.walk.near_blocks[block], tangents, *bin)) return;
  near.ForEachNear(group.lanes, block, [&](std::uint32_t point, float depth) {
    const glm::vec3 r = scene.PointAt(point) - bin->p;
    const float weight = 1.0f - (bin->nearest_depth - depth) / near.margin;
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

// Blocks next to each other follow each other: after some from everywhere few are farther out than those before.
void FindOuters(const GapScene& scene, const NearPlaces& near, TouchBins* bins) {
  const auto find = [&](const TouchGroup& group, std::uint32_t block) {
    FindOuter(scene, near, group, block, &BinOf(group, bins));
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
      if (bin->likely.full() && bin->likely.back().depth >= most) return;
      OfferByDepth({point, MostDepth(scene, point, depth)}, &bin->likely);
    });
  }
}

void FindDeepest(const NearPlaces& near, TouchBins* bins) {
  const auto find = [&](const TouchGroup& group, std::uint32_t block) {
    const float* const depths = near.walk.depths(block);
    const std::uint32_t at = DeepestOf(depths, group.lanes);
    const float deepest = depths[at];
    if (!(deepest >= -near.margin)) return;
    TouchBin& bin = BinOf(group, bins);
    OfferByDepth({deepest, block, group.lanes}, &bin.deep);
    if (deepest <= bin.nearest_depth) return;
    bin.nearest_depth = deepest;
    bin.nearest = near.walk.near_blocks[block] * kBlock + at;
  };
  for (std::uint32_t i = 0; i < near.result.num_near_blocks; ++i) near.ForEachGroup(i, find);
}

}  // namespace

void FillBins(const GapScene& scene, const NearPlaces& near, TouchBins* bins) {
  FindDeepest(near, bins);
  for (TouchBin& bin : *bins) {
    if (bin.nearest == kNoPlace) continue;
    bin.p = scene.PointAt(bin.nearest);
    FindLikely(scene, near, &bin);
  }
  FindOuters(scene, near, bins);
}

}  // namespace vps
