#include "vps/multibody/back_side.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

constexpr int kMaxSteps = 8;

// Length of the column from `a` along `n` (unit, G's inward normal), in metres. Distances are true ones, so that
// stepping by the depth in S cannot leave S; where the depth in G lags behind the length, the middle between both lies
// at or beyond the place where it stops growing.
double ColumnLength(const glm::dvec3& a_G, const glm::dvec3& n_G, double depth_at_a_m, const core::Pose& X_SG,
                    const DistanceField& field_S, const FieldTransform& from_S, const DistanceField& field_G,
                    const FieldTransform& from_G) {
  const double tolerance_m = 0.02 * field_G.voxel_size_m;
  double t = 0.0;
  double step = depth_at_a_m;
  for (int i = 0; i < kMaxSteps; ++i) {
    t += step;
    const glm::dvec3 x_G = a_G + t * n_G;
    const FieldSample in_S = SampleField(field_S, from_S.ToVoxels(glm::vec3(X_SG * x_G)));
    const double depth_m = -static_cast<double>(in_S.distance) * field_S.voxel_size_m;
    if (depth_m <= tolerance_m) {
      // Back or on to the surface along the column.
      const double slope = glm::dot(glm::dvec3(in_S.gradient), X_SG.rotate(n_G));
      if (slope > 0.2) t = std::max(0.0, t + depth_m / slope);
      break;
    }
    step = depth_m;
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    const glm::dvec3 x_G = a_G + t * n_G;
    const double depth_m =
        -static_cast<double>(SampleField(field_G, from_G.ToVoxels(glm::vec3(x_G))).distance) * field_G.voxel_size_m;
    if (depth_m > t - 2.0 * tolerance_m) break;
    t = 0.5 * (t + std::max(depth_m, 0.0));
  }
  return t;
}

}  // namespace

bool NeedsBackSide(const SampleTree& sampled, const SampleTree& of_field_object) {
  const double mean_m2 = sampled.area_m2 / std::max(sampled.num_points, 1U);
  for (std::uint32_t i = 0; i < of_field_object.num_points; ++i) {
    if (of_field_object.points[i / kBlock].area_m2[i % kBlock] < 0.25 * mean_m2) return true;
  }
  return false;
}

double BackShare(double front_count, double back_count) {
  const double fading = std::clamp((200.0 - front_count) / 100.0, 0.0, 1.0);
  const double front = front_count * front_count;
  const double back = fading * back_count * back_count;
  return back > 0.0 ? back / (front + back) : 0.0;
}

BackSum SumBackSide(const BackSide& back, const DistanceField& field, const core::Pose& X_GS,
                    const FieldWalkResult& walk, const FieldWalkScratch& scratch, double margin_m,
                    std::span<ContactPatch> patches, std::uint32_t* num_patches) {
  const core::Pose X_SG = X_GS.inverse();
  const FieldTransform from_G(core::Pose{}, field);
  const FieldTransform from_S(core::Pose{}, *back.field);
  const auto margin = static_cast<float>(margin_m / back.field->voxel_size_m);
  BackSum sum;
  EffectiveCount count;
  *num_patches = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const PointBlock& block = back.points->points[scratch.near_blocks[i]];
    const float* const depths = scratch.depths(i);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      if (depths[k] < -margin || (depths[k] <= 0.0f && *num_patches >= patches.size())) continue;
      const glm::dvec3 a_G(block.x[k], block.y[k], block.z[k]);
      const glm::dvec3 a_S = X_SG * a_G;
      const double depth_m = static_cast<double>(depths[k]) * back.field->voxel_size_m;
      ContactPatch patch;
      const glm::vec3 outwards_S = glm::normalize(SampleField(*back.field, from_S.ToVoxels(glm::vec3(a_S))).gradient);
      patch.n_G = glm::vec3(X_GS.rotate(-glm::dvec3(outwards_S)));
      patch.p_S = glm::vec3(a_S + depth_m * glm::dvec3(outwards_S));  // where a's foot is on S
      patch.penetration_m = static_cast<float>(depth_m);
      if (depth_m > 0.0) {
        const glm::dvec3 n_G(block.nx[k], block.ny[k], block.nz[k]);
        const double t = ColumnLength(a_G, n_G, depth_m, X_SG, *back.field, from_S, field, from_G);
        const double volume = static_cast<double>(block.area_m2[k]) * t;
        const glm::dvec3 force = X_SG.rotate(-volume * n_G);
        const glm::dvec3 moment = glm::cross(a_S, force);
        sum.force_m3 += force;
        sum.moment_m4 += moment;
        sum.volume_m3 += volume;
        sum.square_m4 += volume * t;
        count.Add(volume);
        patch.force_m3 = glm::vec3(force);
        patch.moment_m4 = glm::vec3(moment);
        patch.volume_m3 = static_cast<float>(volume);
        patch.square_m4 = static_cast<float>(volume * t);
      }
      if (*num_patches < patches.size()) patches[(*num_patches)++] = patch;
    }
  }
  sum.num_effective = count.value();
  return sum;
}

}  // namespace vps
