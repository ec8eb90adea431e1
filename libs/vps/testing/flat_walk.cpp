#include "vps/testing/flat_walk.hpp"

#include <algorithm>

namespace vps {
namespace {

// (k1 + k2) / 24 [1/voxel] of the brick that p [voxels] is in.
float CurvatureAt(const DistanceField& field, const glm::vec3& p) {
  const glm::ivec3 n(field.nx, field.ny, field.nz);
  const glm::ivec3 brick = glm::ivec3(glm::clamp(p, glm::vec3(0.0f), glm::vec3(n) - 0.5f)) / 8;
  const std::size_t at = static_cast<std::size_t>((brick.z * (n.y >> 3) + brick.y) * (n.x >> 3) + brick.x);
  return static_cast<float>(field.curvatures[at]) * (kCurvatureStep / 24.0f);
}

}  // namespace

FieldWalkResult WalkFieldFlat(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                              double margin_m) {
  FieldWalkResult result;
  const double s = field.voxel_size_m;
  const FieldTransform T(X_GS, field);
  const auto margin = static_cast<float>(margin_m / s);
  float deepest = -1e30f;
  for (std::uint32_t i = 0; i < sampled.num_points; ++i) {
    const PointBlock& block = sampled.points[i / kBlock];
    const std::uint32_t k = i % kBlock;
    const glm::vec3 p = T.ToVoxels({block.x[k], block.y[k], block.z[k]});
    const float at_point = SampleField(field, p).distance;
    ++result.points_tested;
    if (at_point > margin) continue;
    ++result.num_near;
    // MeanDepth of the kernels.
    const SphereBlock& spheres = sampled.spheres[i / kBlock / kBlock];
    const std::uint32_t of_block = i / kBlock % kBlock;
    const glm::vec3 middle = T.ToVoxels({spheres.x[of_block], spheres.y[of_block], spheres.z[of_block]});
    const float curvature = CurvatureAt(field, middle) / static_cast<float>(s * s);
    const float most = 0.5f * -at_point;
    const float d = at_point < 0.0f ? at_point + std::clamp(block.area_m2[k] * curvature, -most, most) : at_point;
    if (-d > deepest) {
      deepest = -d;
      result.deepest_point = i;
    }
    if (!(d < 0.0f)) continue;
    ++result.num_colliding;
    const double volume = static_cast<double>(block.area_m2[k]) * static_cast<double>(-d) * s;
    const glm::dvec3 f = volume * glm::dvec3(block.nx[k], block.ny[k], block.nz[k]);
    result.force_m3 += f;
    result.moment_m4 += glm::cross(glm::dvec3(block.x[k], block.y[k], block.z[k]), f);
    result.volume_m3 += volume;
    result.square_m4 += volume * static_cast<double>(-d) * s;
  }
  if (result.num_near > 0) result.deepest_m = static_cast<double>(deepest) * s;
  return result;
}

}  // namespace vps
