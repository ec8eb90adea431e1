#include "tools/contact/apart_bound.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace contact {
namespace {

constexpr float kRounding = 0.02f;    // of distances stored in words, voxels
constexpr float kWorstInBand = 0.5f;  // of fitted planes, voxels
constexpr int kMostWalks = 8;

struct Candidate {
  double bound_m;
  std::uint32_t point;
};

struct Centre {
  float distance;  // at the centre
  glm::vec3 centre;
};
// Of the coarse cell that answers at a place.
Centre CentreOf(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  return {sample.cell > 1.0f ? sample.centre_distance : -1e30f, (glm::floor(p / sample.cell) + 0.5f) * sample.cell};
}

glm::vec3 PointOf(const vps::PointBlock& block, std::uint32_t k) {
  return {block.x[k], block.y[k], block.z[k]};
}

}  // namespace

float DistanceAtLeast(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  const glm::vec3 last(static_cast<float>(field.nx) - 0.5f, static_cast<float>(field.ny) - 0.5f,
                       static_cast<float>(field.nz) - 0.5f);
  const glm::vec3 q = glm::clamp(p, glm::vec3(0.0f), last);
  const bool is_in_band = sample.cell == 1.0f;
  const bool is_crease = is_in_band && sample.centre_offset == 0.0f;
  // Distances of two places differ by no more than the places lie apart.
  float least = is_crease ? -1e30f : sample.centre_distance - sample.centre_offset - kRounding;
  if (is_in_band) least = std::max(least, sample.distance - kWorstInBand);
  // A cell farther out, at a and l along and across the gradient, loses no more than l^2 / 2 a: d >= d(c) - |q - c|.
  if (!is_in_band) {
    for (const float ahead : {1.0f, 2.0f, 4.0f, 8.0f}) {
      const glm::vec3 at = q + ahead * sample.cell * glm::normalize(sample.gradient);
      if (at != glm::clamp(at, glm::vec3(0.0f), last)) break;
      const Centre farther = CentreOf(field, at);
      least = std::max(least, farther.distance - glm::length(q - farther.centre) - kRounding);
    }
  }
  if (p == q) return least;
  // The surface keeps clear of the grid's faces. And q is the place of the grid, which is convex, that is nearest to p:
  // the angle at q between p and any place of the surface is not acute.
  const glm::vec3 border(static_cast<float>(vps::DistanceField::kMinBorder) - 0.5f);
  const float to_box = glm::length(p - glm::clamp(p, border, last - border));
  return std::max(to_box, std::hypot(glm::length(p - q), std::max(least, 0.0f)));
}

double ApartBound_m(const vps::SampleTree& sampled, const vps::DistanceField& field, const core::Pose& X_GS,
                    vps::FieldWalkScratch* scratch) {
  // Widens the walk until it lists every sample whose patch can be the nearest.
  double margin_m = 2.0 * sampled.reach_m;
  vps::FieldWalkResult walk;
  for (int i = 0; i < kMostWalks; ++i) {
    walk = vps::WalkField(sampled, field, X_GS, margin_m, scratch);
    const double wanted_m = walk.num_near > 0 ? -walk.deepest_m + sampled.reach_m + field.voxel_size_m
                                              : 1.1 * (margin_m + walk.free_distance_m) + 2.0 * sampled.reach_m;
    if (walk.num_near > 0 && wanted_m <= margin_m) break;
    margin_m = wanted_m;
  }
  if (walk.num_near == 0) return std::max(0.0, margin_m + walk.free_distance_m - sampled.reach_m);
  const double s = field.voxel_size_m;
  const vps::FieldTransform T(X_GS, field);
  const auto reach_m = [&](std::uint32_t point) {
    return sampled.fine.empty() ? sampled.reach_m : static_cast<double>(sampled.fine[point].reach_m);
  };
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = scratch->near_blocks[i];
    for (std::uint32_t k = 0; k < vps::kBlock && at * vps::kBlock + k < sampled.num_points; ++k) {
      const std::uint32_t point = at * vps::kBlock + k;
      const float distance = DistanceAtLeast(field, T.ToVoxels(PointOf(sampled.points[at], k)));
      candidates.push_back({static_cast<double>(distance) * s - reach_m(point), point});
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.bound_m < b.bound_m; });
  double least_m = margin_m - sampled.reach_m;  // of the samples that were not listed
  for (const Candidate& candidate : candidates) {
    if (candidate.bound_m >= least_m) break;
    double bound_m = candidate.bound_m;
    if (!sampled.fine.empty()) {
      const vps::FineBlock& fine = sampled.fine[candidate.point];
      vps::PointBlock points;
      vps::Unpack(fine, sampled.points[candidate.point / vps::kBlock], candidate.point % vps::kBlock, 1.0f, &points);
      float nearest = 1e30f;
      for (std::uint32_t j = 0; j < vps::kBlock; ++j) {
        if (fine.share[j] > 0) nearest = std::min(nearest, DistanceAtLeast(field, T.ToVoxels(PointOf(points, j))));
      }
      bound_m = std::max(bound_m, static_cast<double>(nearest) * s - static_cast<double>(fine.cover_m));
    }
    least_m = std::min(least_m, bound_m);
  }
  return std::max(0.0, least_m);
}

}  // namespace contact
