#include "vps/walk/field_walk.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>

#include "vps/walk/bound_free_distance.hpp"
#include "vps/walk/walk_memory.hpp"

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

// Blocks of a chunk: 2,048 points. Not derived: long against handing it to a worker.
constexpr std::uint32_t kChunkBlocks = 128;

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

FieldWalkScratch::FieldWalkScratch(const SampleTree& tree, InstructionSet set)
    : near_blocks(tree.points.size()),
      queue_(2 * (tree.points.size() + kBlock)),
      estimates_(tree.points.size() + kBlock),
      picked_(tree.points.size() + kBlock),
      near_slots_(tree.points.size()),
      near_depths_(tree.points.size()),
      chunks_(tree.points.size() / kChunkBlocks + 1),
      kernels_(KernelsOf(set)) {}

FieldTransform::FieldTransform(const core::Pose& X_GS, const DistanceField& field) {
  const glm::dmat3 R = glm::mat3_cast(X_GS.rotation);  // column major
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[row][column] = static_cast<float>(R[column][row] / field.voxel_size_m);
    t[row] = static_cast<float>((X_GS.translation[row] - field.origin_m[row]) / field.voxel_size_m);
  }
}

FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, FieldWalkScratch* scratch) {
  const std::uint32_t num_chunks = scratch->Prepare(sampled, field, X_GS, margin_m);
  for (std::uint32_t i = 0; i < num_chunks; ++i) scratch->Evaluate(i);
  return scratch->Finish();
}

// The blocks that may come near, from the tree. `estimates`: WalkCull.
void FieldWalkScratch::FindBlocks(float* estimates) {
  WalkCull cull{};
  cull.queue = queue_.data();
  cull.queue_half = static_cast<std::uint32_t>(queue_.size() / 2);
  cull.estimates = estimates;
  kernels_.cull(input_, &cull);
  result_.spheres_tested += cull.spheres_tested;
  free_distance_ = static_cast<double>(cull.free_distance) - static_cast<double>(input_.margin);
  blocks_ = queue_.data() + (cull.blocks == queue_.data() ? 0 : cull.queue_half);
  num_blocks_ = cull.num_blocks;
}

std::uint32_t FieldWalkScratch::Prepare(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                                        double margin_m) {
  result_ = {};
  num_chunks_ = 0;
  voxel_size_m_ = field.voxel_size_m;
  bool was_apart = false;
  if (memory != nullptr) {
    const double free_m = memory->RemainingFreeDistance_m(sampled, field, X_GS, margin_m);
    free_distance_ = free_m / field.voxel_size_m;
    if (free_m > 0.0) return 0;
    was_apart = memory->free_m > 0.0;
    *memory = {&sampled, &field, margin_m, X_GS, X_GS * sampled.centre_m};
  }
  input_ = MakeFieldInput(field, X_GS);
  input_.points = sampled.points.data();
  input_.spheres = sampled.spheres.data();
  input_.level_begin = sampled.level_begin.data();
  input_.num_levels = sampled.num_levels;
  input_.margin = static_cast<float>(margin_m / field.voxel_size_m);
  if (was_apart) {
    // A larger lower bound of the distance lets a pair rest for more cycles.
    constexpr double kWorthWhile = 2.0;  // voxels, not derived: nearer pairs get the walk's better bound
    free_distance_ = BoundFreeDistance(input_, kernels_, &result_.spheres_tested) - static_cast<double>(input_.margin);
    if (free_distance_ > kWorthWhile) return 0;
  }
  FindBlocks();
  result_.points_due = num_blocks_ * kBlock;
  if (most_points != 0 && result_.points_due > most_points) PickDeepest(most_points / kBlock);
  // Chunks are cut by the blocks' numbers: sums depend neither on the blocks tested besides nor on this scratch.
  for (std::uint32_t begin = 0; begin < num_blocks_;) {
    const std::uint32_t last = blocks_[begin] | (kChunkBlocks - 1);
    const auto end =
        static_cast<std::uint32_t>(std::upper_bound(blocks_ + begin, blocks_ + num_blocks_, last) - blocks_);
    WalkChunk& chunk = chunks_[num_chunks_++];
    chunk.blocks = blocks_ + begin;
    chunk.num_blocks = end - begin;
    chunk.near_blocks = near_blocks.data() + begin;
    chunk.near_depths = reinterpret_cast<float(*)[kBlock]>(near_depths_.data() + begin);
    begin = end;
  }
  return num_chunks_;
}

FieldWalkResult FieldWalkScratch::Finish() {
  float least = kBeyondBand;
  float deepest = -1e30f;
  double lanes[WalkChunk::kNumSums][kBlock] = {};
  for (std::uint32_t i = 0; i < num_chunks_; ++i) {
    const WalkChunk& chunk = chunks_[i];
    result_.points_tested += chunk.num_blocks * kBlock;
    least = std::min(least, chunk.free_distance - kModelSlack);
    const auto first = static_cast<std::uint32_t>(chunk.near_blocks - near_blocks.data());
    for (std::uint32_t k = 0; k < chunk.num_near_blocks; ++k) {
      near_blocks[result_.num_near_blocks] = chunk.near_blocks[k];
      near_slots_[result_.num_near_blocks++] = first + k;
    }
    if (chunk.num_near == 0) continue;
    result_.num_near += chunk.num_near;
    result_.num_colliding += chunk.num_colliding;
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const std::uint32_t point = chunk.depth_block[k] * kBlock + k;
      if (chunk.depth[k] > deepest || (chunk.depth[k] == deepest && point < result_.deepest_point)) {
        deepest = chunk.depth[k];
        result_.deepest_point = point;
      }
      for (std::uint32_t s = 0; s < WalkChunk::kNumSums; ++s) lanes[s][k] += static_cast<double>(chunk.sums[s][k]);
    }
  }
  if (result_.num_near == 0) {
    const double of_points = static_cast<double>(least - input_.margin);
    const double free_distance = num_chunks_ == 0 ? free_distance_ : std::min(free_distance_, of_points);
    result_.free_distance_m = std::max(0.0, free_distance * voxel_size_m_);
    // Without a sphere tested the memory still holds.
    if (memory != nullptr && result_.spheres_tested > 0) memory->free_m = result_.free_distance_m;
    return result_;
  }
  const double s = voxel_size_m_;
  const auto sum = [&](WalkChunk::Sum of) { return std::accumulate(lanes[of], lanes[of] + kBlock, 0.0); };
  result_.deepest_m = static_cast<double>(deepest) * s;
  result_.missed_m3 = s * std::sqrt(sum(WalkChunk::kMissed) * std::sqrt(sum(WalkChunk::kMissedSquared)));
  result_.force_m3 = s * glm::dvec3(sum(WalkChunk::kFx), sum(WalkChunk::kFy), sum(WalkChunk::kFz));
  result_.moment_m4 = s * glm::dvec3(sum(WalkChunk::kMx), sum(WalkChunk::kMy), sum(WalkChunk::kMz));
  result_.volume_m3 = s * sum(WalkChunk::kVolume);
  result_.square_m4 = s * s * sum(WalkChunk::kSquare);
  return result_;
}

}  // namespace vps
