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

WalkKernels KernelsOf(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::kAvx512) return Avx512WalkKernels();
  if (set == InstructionSet::kAvx2) return Avx2WalkKernels();
#else
  static_cast<void>(set);
#endif
  return PortableWalkKernels();
}

// Lower bound of the distance of a sphere's points less `needed`, voxels. The sphere around everything comes first:
// most pairs are far apart. Outside the grid its box says enough.
double RootRoom(const DistanceField& field, const glm::dvec3& centre, double needed) {
  const double room =
      glm::length(centre - glm::clamp(centre, glm::dvec3(0.0), glm::dvec3(field.nx, field.ny, field.nz))) - needed;
  if (room > 0.0) return room;
  const FieldSample root = SampleField(field, glm::vec3(centre));
  return std::max(room, static_cast<double>(root.centre_distance) - static_cast<double>(root.centre_offset) - needed);
}

// At most so many chunks, so that their sums stay small beside the points.
constexpr std::uint32_t kMostChunks = 64;
constexpr std::uint32_t kSmallestChunkShift = 8;

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
    : near_blocks(tree.points.size()),
      near_slots(tree.points.size()),
      near_depths(tree.points.size()),
      queue_(2 * (tree.points.size() + kBlock)),
      chunk_near_(tree.points.size()),
      chunks_(std::min<std::size_t>(kMostChunks, (tree.points.size() >> kSmallestChunkShift) + 1)) {}

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
  const std::uint32_t num_chunks = PrepareWalk(sampled, field, X_GS, margin_m, set, scratch);
  for (std::uint32_t i = 0; i < num_chunks; ++i) EvaluateChunk(scratch, i);
  return FinishWalk(scratch);
}

std::uint32_t PrepareWalk(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, InstructionSet set, FieldWalkScratch* scratch) {
  const double s = field.voxel_size_m;
  scratch->voxel_size_m_ = s;
  scratch->num_chunks_ = 0;
  // By the tree alone, not by the room in the scratch, which may be another tree's: sums are added chunk by chunk.
  scratch->chunk_shift_ = kSmallestChunkShift;
  while (sampled.points.size() >> scratch->chunk_shift_ >= kMostChunks) ++scratch->chunk_shift_;
  scratch->spheres_tested_ = 1;
  const double needed = sampled.radius_m / s + margin_m / s + static_cast<double>(kCullSlack);
  scratch->room_ = RootRoom(field, (X_GS * sampled.centre_m - field.origin_m) / s, needed);
  if (scratch->room_ > 0.0) return 0;

  const FieldTransform T(X_GS, field);
  WalkInput& in = scratch->input_;
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
  in.partial_block = sampled.num_points % kBlock != 0 ? sampled.num_points / kBlock : 0xffffffffU;
  std::memcpy(in.m, T.m, sizeof in.m);
  std::memcpy(in.t, T.t, sizeof in.t);
  in.last_leaves = static_cast<std::uint32_t>((sampled.points.size() - 1) / kBlock);
  in.voxels_per_m = static_cast<float>(1.0 / s);
  in.m_per_voxel = static_cast<float>(s);
  in.margin = static_cast<float>(margin_m / s);
  scratch->kernels_ = KernelsOf(set);
  WalkCull cull{};
  cull.queue = scratch->queue_.data();
  cull.queue_half = static_cast<std::uint32_t>(scratch->queue_.size() / 2);
  scratch->kernels_.cull(in, &cull);
  scratch->spheres_tested_ += cull.spheres_tested;
  scratch->room_ = static_cast<double>(cull.room) - static_cast<double>(in.margin);
  scratch->blocks_ = cull.blocks;
  for (std::uint32_t begin = 0; begin < cull.num_blocks;) {
    FieldWalkScratch::Chunk& chunk = scratch->chunks_[scratch->num_chunks_++];
    const std::uint32_t last = cull.blocks[begin] | ((1U << scratch->chunk_shift_) - 1);
    chunk.begin = begin;
    chunk.end = static_cast<std::uint32_t>(std::upper_bound(cull.blocks + begin, cull.blocks + cull.num_blocks, last) -
                                           cull.blocks);
    begin = chunk.end;
  }
  return scratch->num_chunks_;
}

void EvaluateChunk(FieldWalkScratch* scratch, std::uint32_t index) {
  FieldWalkScratch::Chunk& chunk = scratch->chunks_[index];
  WalkChunk part;
  part.blocks = scratch->blocks_ + chunk.begin;
  part.num_blocks = chunk.end - chunk.begin;
  part.near_blocks = scratch->chunk_near_.data() + chunk.begin;
  part.near_depths = reinterpret_cast<float(*)[kBlock]>(scratch->near_depths.data() + chunk.begin);
  scratch->kernels_.evaluate(scratch->input_, part, &chunk.sums);
}

FieldWalkResult FinishWalk(FieldWalkScratch* scratch) {
  FieldWalkResult result;
  result.spheres_tested = scratch->spheres_tested_;
  if (scratch->num_chunks_ == 0) {
    result.free_distance_m = std::max(0.0, scratch->room_ * scratch->voxel_size_m_);
    return result;
  }
  double room = scratch->room_;
  float deepest = -1e30f;
  double sums[WalkSums::kNumSums][kBlock] = {};
  for (std::uint32_t i = 0; i < scratch->num_chunks_; ++i) {
    const FieldWalkScratch::Chunk& chunk = scratch->chunks_[i];
    result.points_tested += (chunk.end - chunk.begin) * kBlock;
    room = std::min(room,
                    static_cast<double>(std::min(chunk.sums.room - kModelSlack, kBeyondBand) - scratch->input_.margin));
    for (std::uint32_t k = 0; k < chunk.sums.num_near_blocks; ++k) {
      scratch->near_blocks[result.num_near_blocks] = scratch->chunk_near_[chunk.begin + k];
      scratch->near_slots[result.num_near_blocks++] = chunk.begin + k;
    }
    if (chunk.sums.num_near == 0) continue;
    result.num_near += chunk.sums.num_near;
    result.num_colliding += chunk.sums.num_colliding;
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const std::uint32_t point = chunk.sums.depth_block[k] * kBlock + k;
      if (chunk.sums.depth[k] > deepest || (chunk.sums.depth[k] == deepest && point < result.deepest_point)) {
        deepest = chunk.sums.depth[k];
        result.deepest_point = point;
      }
    }
    if (chunk.sums.num_colliding == 0) continue;
    for (std::uint32_t s = 0; s < WalkSums::kNumSums; ++s) {
      for (std::uint32_t k = 0; k < kBlock; ++k) sums[s][k] += chunk.sums.of[s][k];
    }
  }
  const double s = scratch->voxel_size_m_;
  if (result.num_near == 0) {
    result.free_distance_m = std::max(0.0, room * s);
    return result;
  }
  result.deepest_m = static_cast<double>(deepest) * s;
  if (result.num_colliding == 0) return result;
  result.force_m3 = s * glm::dvec3(SumOf(sums[WalkSums::kFx]), SumOf(sums[WalkSums::kFy]), SumOf(sums[WalkSums::kFz]));
  result.moment_m4 = s * glm::dvec3(SumOf(sums[WalkSums::kMx]), SumOf(sums[WalkSums::kMy]), SumOf(sums[WalkSums::kMz]));
  result.volume_m3 = s * SumOf(sums[WalkSums::kVolume]);
  result.square_m4 = s * s * SumOf(sums[WalkSums::kSquare]);
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
