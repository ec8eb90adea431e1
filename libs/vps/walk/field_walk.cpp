#include "vps/walk/field_walk.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "vps/walk/bound_free_distance.hpp"
#include "vps/walk/walk_input.hpp"
#include "vps/walk/walk_kernel.hpp"
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

// Lower bound of the distance of the points of the root sphere less `needed`, voxels. Outside the grid the distance to
// the grid's box is enough: most pairs are far apart.
double BoundFreeDistanceOfRoot(const DistanceField& field, const glm::dvec3& centre, double needed) {
  const double free_distance =
      glm::length(centre - glm::clamp(centre, glm::dvec3(0.0), glm::dvec3(field.nx, field.ny, field.nz))) - needed;
  if (free_distance > 0.0) return free_distance;
  const FieldSample root = SampleField(field, glm::vec3(centre));
  return std::max(free_distance,
                  static_cast<double>(root.centre_distance) - static_cast<double>(root.centre_offset) - needed);
}

WalkInput MakeInput(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m) {
  WalkInput in = MakeFieldInput(field, X_GS);
  in.points = sampled.points.data();
  in.spheres = sampled.spheres.data();
  in.level_begin = sampled.level_begin.data();
  in.num_levels = sampled.num_levels;
  if (sampled.num_points % kBlock != 0) in.partial_block = sampled.num_points / kBlock;
  in.last_leaves = static_cast<std::uint32_t>((sampled.points.size() - 1) / kBlock);
  in.margin = static_cast<float>(margin_m / field.voxel_size_m);
  return in;
}

// At most so many chunks of at least 2^7 blocks (2,048 points). Not derived: the sums of a chunk (1.2 KB) stay small
// beside its points, and a chunk long against handing it to a worker.
constexpr std::uint32_t kMostChunks = 64;
constexpr std::uint32_t kSmallestChunkShift = 7;

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
      bounds_(tree.points.size() + kBlock),
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

// The blocks that may come near, from the tree. `kept`, `skin`: WalkCull.
std::uint32_t FieldWalkScratch::FindBlocks(float* kept, float skin) {
  WalkCull cull{};
  cull.queue = queue_.data();
  cull.queue_half = static_cast<std::uint32_t>(queue_.size() / 2);
  cull.kept = kept;
  cull.skin = skin;
  kernels_.cull(input_, &cull);
  spheres_tested_ += cull.spheres_tested;
  free_distance_ = static_cast<double>(cull.free_distance) - static_cast<double>(input_.margin);
  blocks_ = queue_.data() + (cull.blocks == queue_.data() ? 0 : cull.queue_half);
  return cull.num_blocks;
}

// The same, and keeps a list for the next cycles.
std::uint32_t FieldWalkScratch::ListBlocks(double skin_voxels) {
  const std::uint32_t num_listed = FindBlocks(bounds_.data(), static_cast<float>(skin_voxels));
  memory->KeepList(skin_voxels, free_distance_, {blocks_, num_listed}, bounds_.data());
  std::uint32_t count = 0;
  auto free_distance = static_cast<float>(free_distance_);
  for (std::uint32_t i = 0; i < num_listed; ++i) {
    const bool is_due = bounds_[i] <= 0.0f;
    blocks_[count] = blocks_[i];
    count += is_due ? 1 : 0;
    free_distance = is_due ? free_distance : std::min(free_distance, bounds_[i]);
  }
  free_distance_ = static_cast<double>(free_distance);
  return count;
}

// A larger lower bound of the distance lets a pair rest for more cycles.
bool FieldWalkScratch::IsFarApart() {
  constexpr double kWorthWhile = 2.0;  // voxels, not derived: nearer pairs get the walk's better bound
  spheres_tested_ = BoundFreeDistance(input_, kernels_, &free_distance_);
  free_distance_ -= static_cast<double>(input_.margin);
  return free_distance_ > kWorthWhile;
}

void FieldWalkScratch::RememberApart(double free_voxels) const {
  // Without a sphere tested the memory still holds.
  if (memory != nullptr && spheres_tested_ > 0) memory->KeepApart(free_voxels);
}

// Chunks hold blocks whose numbers differ only in the last bits: by the tree alone, not by the room in the scratch,
// which may be another tree's: sums are added chunk by chunk.
void FieldWalkScratch::CutIntoChunks(std::uint32_t num_blocks) {
  for (std::uint32_t begin = 0; begin < num_blocks;) {
    Chunk& chunk = chunks_[num_chunks_++];
    const std::uint32_t last = blocks_[begin] | ((1U << chunk_shift_) - 1);
    chunk.begin = begin;
    chunk.end = static_cast<std::uint32_t>(std::upper_bound(blocks_ + begin, blocks_ + num_blocks, last) - blocks_);
    begin = chunk.end;
  }
}

std::uint32_t PrepareWalk(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, InstructionSet set, FieldWalkScratch* scratch) {
  using Advice = FieldWalkMemory::Advice;
  const double s = field.voxel_size_m;
  scratch->voxel_size_m_ = s;
  scratch->num_chunks_ = 0;
  scratch->spheres_tested_ = 0;
  scratch->is_cut_short_ = false;
  scratch->points_due_ = 0;
  FieldWalkMemory* const memory = scratch->memory;
  const bool was_apart = memory != nullptr && memory->is_apart();
  Advice advice{Advice::kStartAnew, 0.0};
  if (memory != nullptr) advice = memory->Advise(sampled, field, X_GS, margin_m);
  if (advice.what == Advice::kStayApart) {
    scratch->free_distance_ = advice.voxels;
    return 0;
  }
  if (advice.what != Advice::kUseList && !was_apart) {
    scratch->spheres_tested_ = 1;
    const double needed = sampled.radius_m / s + margin_m / s + static_cast<double>(kCullSlack);
    scratch->free_distance_ = BoundFreeDistanceOfRoot(field, (X_GS * sampled.centre_m - field.origin_m) / s, needed);
    if (scratch->free_distance_ > 0.0) return 0;
  }
  scratch->input_ = MakeInput(sampled, field, X_GS, margin_m);
  scratch->kernels_ = KernelsOf(set);
  if (was_apart && scratch->IsFarApart()) return 0;
  scratch->chunk_shift_ = kSmallestChunkShift;
  while (sampled.points.size() >> scratch->chunk_shift_ >= kMostChunks) ++scratch->chunk_shift_;
  std::uint32_t num_blocks = 0;
  if (advice.what == Advice::kUseList) {
    num_blocks = memory->Select(advice.voxels, scratch->queue_.data(), &scratch->free_distance_);
    scratch->blocks_ = scratch->queue_.data();
  } else {
    num_blocks = advice.what == Advice::kMakeList ? scratch->ListBlocks(advice.voxels) : scratch->FindBlocks();
  }
  scratch->points_due_ = num_blocks * kBlock;
  if (scratch->most_points != 0 && num_blocks * kBlock > scratch->most_points) {
    num_blocks = scratch->PickDeepest(scratch->most_points / kBlock);
  }
  if (memory != nullptr) memory->num_tested_ = num_blocks;
  scratch->CutIntoChunks(num_blocks);
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
  result.is_cut_short = scratch->is_cut_short_;
  if (scratch->num_chunks_ == 0) {
    scratch->RememberApart(scratch->free_distance_);
    result.free_distance_m = std::max(0.0, scratch->free_distance_ * scratch->voxel_size_m_);
    return result;
  }
  double free_distance = scratch->free_distance_;
  float deepest = -1e30f;
  double sums[WalkSums::kNumSums][kBlock] = {};
  for (std::uint32_t i = 0; i < scratch->num_chunks_; ++i) {
    const FieldWalkScratch::Chunk& chunk = scratch->chunks_[i];
    result.points_tested += (chunk.end - chunk.begin) * kBlock;
    free_distance = std::min(
        free_distance,
        static_cast<double>(std::min(chunk.sums.free_distance - kModelSlack, kBeyondBand) - scratch->input_.margin));
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
    for (std::uint32_t s = 0; s < WalkSums::kNumSums; ++s) {
      for (std::uint32_t k = 0; k < kBlock; ++k) sums[s][k] += chunk.sums.of[s][k];
    }
  }
  const double s = scratch->voxel_size_m_;
  if (result.num_near == 0) {
    scratch->RememberApart(free_distance);
    result.free_distance_m = std::max(0.0, free_distance * s);
    return result;
  }
  result.deepest_m = static_cast<double>(deepest) * s;
  result.missed_m3 = s * std::sqrt(SumOf(sums[WalkSums::kMissed]) * std::sqrt(SumOf(sums[WalkSums::kMissedSquared])));
  if (result.num_colliding == 0) return result;
  result.force_m3 = s * glm::dvec3(SumOf(sums[WalkSums::kFx]), SumOf(sums[WalkSums::kFy]), SumOf(sums[WalkSums::kFz]));
  result.moment_m4 = s * glm::dvec3(SumOf(sums[WalkSums::kMx]), SumOf(sums[WalkSums::kMy]), SumOf(sums[WalkSums::kMz]));
  result.volume_m3 = s * SumOf(sums[WalkSums::kVolume]);
  result.square_m4 = s * s * SumOf(sums[WalkSums::kSquare]);
  return result;
}

namespace {

// (k1 + k2) / 24 [1/voxel] of the brick that the middle of a point block is in; rounded as the kernels round.
float CurvatureAt(const SampleTree& sampled, const DistanceField& field, const FieldTransform& T, std::uint32_t block) {
  const SphereBlock& spheres = sampled.spheres[block / kBlock];
  const std::uint32_t k = block % kBlock;
  const glm::ivec3 n = glm::ivec3(field.nx, field.ny, field.nz);
  glm::ivec3 brick;
  for (int a = 0; a < 3; ++a) {
    const float* const m = T.m[a];
    const float p = std::fma(m[0], spheres.x[k], std::fma(m[1], spheres.y[k], std::fma(m[2], spheres.z[k], T.t[a])));
    brick[a] = static_cast<int>(std::max(std::min(p, static_cast<float>(n[a]) - 0.5f), 0.0f)) >> 3;
  }
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
  float curvature = 0.0f;
  for (std::uint32_t i = 0; i < sampled.num_points; ++i) {
    const PointBlock& block = sampled.points[i / kBlock];
    const std::uint32_t k = i % kBlock;
    if (k == 0) curvature = CurvatureAt(sampled, field, T, i / kBlock) / static_cast<float>(s * s);
    const float at_point = SampleField(field, T.ToVoxels({block.x[k], block.y[k], block.z[k]})).distance;
    ++result.points_tested;
    if (at_point > margin) continue;
    ++result.num_near;
    // MeanDepth of the kernels.
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
