#include "vps/walk/field_walk.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

InstructionSet FindBest() {
  InstructionSet best = InstructionSet::kPortable;
  if (IsAvailable(InstructionSet::kAvx2)) best = InstructionSet::kAvx2;
  if (IsAvailable(InstructionSet::kAvx512)) best = InstructionSet::kAvx512;
  if (const char* wish = std::getenv("VR_OOS_SIMD"); wish != nullptr) {
    if (std::strcmp(wish, "portable") == 0) return InstructionSet::kPortable;
    if (std::strcmp(wish, "avx2") == 0) return std::min(best, InstructionSet::kAvx2);
  }
  return best;
}

WalkKernel KernelOf(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx512) return WalkAvx512;
  if (set == InstructionSet::kAvx2) return WalkAvx2;
#else
  static_cast<void>(set);
#endif
  return WalkPortable;
}

double SumOf(const double (&lanes)[kBlock]) {
  double sum = 0.0;
  for (const double lane : lanes) sum += lane;
  return sum;
}

}  // namespace

bool IsAvailable(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx2) return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (set == InstructionSet::kAvx512) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512cd");
  }
#endif
  return set == InstructionSet::kPortable;
}

InstructionSet BestInstructionSet() {
  static const InstructionSet best = FindBest();
  return best;
}

FieldWalkScratch::FieldWalkScratch(const SampleTree& tree)
    : near_blocks(tree.points.size()), near_depths(tree.points.size()), queue(2 * (tree.points.size() + kBlock)) {}

FieldTransform::FieldTransform(const core::Pose& X_GS, const DistanceField& field) {
  const glm::dmat3 R = glm::mat3_cast(X_GS.rotation);  // column major
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[row][column] = static_cast<float>(R[column][row] / field.voxel_size_m);
    t[row] = static_cast<float>((X_GS.translation[row] - field.origin_m[row]) / field.voxel_size_m);
  }
}

FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, FieldWalkScratch* scratch) {
  return WalkField(sampled, field, X_GS, margin_m, BestInstructionSet(), scratch);
}

FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, InstructionSet set, FieldWalkScratch* scratch) {
  FieldWalkResult result;
  const double s = field.voxel_size_m;
  // The sphere around everything first: most pairs are far apart. Outside the grid its box says enough.
  result.spheres_tested = 1;
  const double needed = sampled.radius_m / s + margin_m / s + static_cast<double>(kCullSlack);  // voxels
  const glm::dvec3 centre = (X_GS * sampled.centre_m - field.origin_m) / s;
  double bound = glm::length(centre - glm::clamp(centre, glm::dvec3(0.0), glm::dvec3(field.nx, field.ny, field.nz)));
  if (bound <= needed) {
    const FieldSample root = SampleField(field, glm::vec3(centre));
    bound = std::max(bound, static_cast<double>(root.centre_distance) - static_cast<double>(root.centre_offset));
  }
  if (bound > needed) {
    result.free_distance_m = (bound - needed) * s;
    return result;
  }

  const FieldTransform T(X_GS, field);
  WalkInput in;
  in.bricks = field.bricks.data();
  in.words = field.words.data();
  in.creases = field.creases.data();
  in.coarse = field.coarse.data();
  in.nx = field.nx;
  in.ny = field.ny;
  in.nz = field.nz;
  in.coarse_shift = field.coarse_shift;
  in.points = sampled.points.data();
  in.spheres = sampled.spheres.data();
  in.level_begin = sampled.level_begin.data();
  in.num_levels = sampled.num_levels;
  std::memcpy(in.m, T.m, sizeof in.m);
  std::memcpy(in.t, T.t, sizeof in.t);
  in.voxels_per_m = static_cast<float>(1.0 / s);
  in.margin = static_cast<float>(margin_m / s);
  WalkScratch memory;
  memory.queue = scratch->queue.data();
  memory.queue_half = static_cast<std::uint32_t>(scratch->queue.size() / 2);
  memory.near_blocks = scratch->near_blocks.data();
  memory.near_depths = reinterpret_cast<float(*)[kBlock]>(scratch->near_depths.data());
  WalkOutput out;
  KernelOf(set)(in, memory, &out);

  result.spheres_tested += out.spheres_tested;
  result.points_tested = out.points_tested;
  result.num_near = out.num_near;
  result.num_colliding = out.num_colliding;
  result.num_near_blocks = out.num_near_blocks;
  if (out.num_near == 0) {
    result.free_distance_m = std::max(0.0, static_cast<double>(out.room) * s);
    return result;
  }
  float deepest = -1e30f;
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const std::uint32_t point = out.depth_block[k] * kBlock + k;
    if (out.depth[k] > deepest || (out.depth[k] == deepest && point < result.deepest_point)) {
      deepest = out.depth[k];
      result.deepest_point = point;
    }
  }
  result.deepest_m = static_cast<double>(deepest) * s;
  result.force_m3 = s * glm::dvec3(SumOf(out.sums[WalkOutput::kFx]), SumOf(out.sums[WalkOutput::kFy]),
                                   SumOf(out.sums[WalkOutput::kFz]));
  result.moment_m4 = s * glm::dvec3(SumOf(out.sums[WalkOutput::kMx]), SumOf(out.sums[WalkOutput::kMy]),
                                    SumOf(out.sums[WalkOutput::kMz]));
  result.volume_m3 = s * SumOf(out.sums[WalkOutput::kVolume]);
  result.square_m4 = s * s * SumOf(out.sums[WalkOutput::kSquare]);
  return result;
}

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
    const float d = SampleField(field, T.ToVoxels({block.x[k], block.y[k], block.z[k]})).distance;
    ++result.points_tested;
    if (d > margin) continue;
    ++result.num_near;
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
