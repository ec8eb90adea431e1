#include "vps/multibody/fast_pair_query.hpp"

#include <algorithm>
#include <cstring>

namespace vps {
namespace {

struct Front {
  const SampleTree& sampled;
  const DistanceField& field;
  FieldTransform T;
};

glm::vec3 PointOf(const PointBlock& block, std::uint32_t k) {
  return {block.x[k], block.y[k], block.z[k]};
}

// The gap's derivative is the field's gradient; the point's own normal is 45 degrees off at an edge.
void Place(const Front& front, const PointBlock& block, std::uint32_t k, float depth_m, ContactPatch* patch) {
  patch->p_S = PointOf(block, k);
  patch->n_G = SampleField(front.field, front.T.ToVoxels(patch->p_S)).gradient;
  patch->penetration_m = depth_m;
}

void SetSums(const PointBlock& block, std::uint32_t k, float depth_m, ContactPatch* patch) {
  const float volume = depth_m > 0.0f ? block.area_m2[k] * depth_m : 0.0f;
  patch->force_m3 = volume * glm::vec3(block.nx[k], block.ny[k], block.nz[k]);
  patch->moment_m4 = glm::cross(PointOf(block, k), patch->force_m3);
  patch->volume_m3 = volume;
  patch->square_m4 = volume * depth_m;
}

// Four lanes.
using F4 = float __attribute__((vector_size(16)));
using I4 = std::int32_t __attribute__((vector_size(16)));

F4 Load(const float* from) {
  F4 lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

float SumOf(const F4& lanes) {
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

// Of all points of a block.
void SetSums(const PointBlock& block, const float* depths, float voxel_m, ContactPatch* patch) {
  F4 force[3] = {};
  F4 moment[3] = {};
  F4 sum = {};
  F4 square = {};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 d = Load(depths + k);
    const F4 depth_m = (d > 0.0f ? d : F4{}) * voxel_m;
    const F4 volume = Load(block.area_m2 + k) * depth_m;  // places without a point have no area
    const F4 p[3] = {Load(block.x + k), Load(block.y + k), Load(block.z + k)};
    const F4 f[3] = {volume * Load(block.nx + k), volume * Load(block.ny + k), volume * Load(block.nz + k)};
    for (int i = 0; i < 3; ++i) {
      force[i] += f[i];
      moment[i] += p[(i + 1) % 3] * f[(i + 2) % 3] - p[(i + 2) % 3] * f[(i + 1) % 3];
    }
    sum += volume;
    square += volume * depth_m;
  }
  for (int i = 0; i < 3; ++i) {
    patch->force_m3[i] = SumOf(force[i]);
    patch->moment_m4[i] = SumOf(moment[i]);
  }
  patch->volume_m3 = SumOf(sum);
  patch->square_m4 = SumOf(square);
}

std::uint32_t FindDeepest(const float* depths) {
  F4 deepest = Load(depths);
  I4 at = {0, 1, 2, 3};
  for (std::int32_t k = 4; k < static_cast<std::int32_t>(kBlock); k += 4) {
    const F4 d = Load(depths + k);
    const I4 lanes = {k, k + 1, k + 2, k + 3};
    at = d > deepest ? lanes : at;
    deepest = d > deepest ? d : deepest;
  }
  int best = 0;
  for (int j = 1; j < 4; ++j) {
    if (deepest[j] > deepest[best]) best = j;
  }
  return static_cast<std::uint32_t>(at[best]);
}

// Patches of the points that a walk found near.
std::uint32_t MakePatches(const Front& front, const FieldWalkResult& walk, const FieldWalkScratch& scratch,
                          double margin_m, ContactPatch* patches) {
  const auto voxel_m = static_cast<float>(front.field.voxel_size_m);
  const float margin = static_cast<float>(margin_m) / voxel_m;
  const bool takes_all = walk.num_near <= kMaxSinglePoints;
  std::uint32_t mask = 0;
  while (walk.num_near_blocks / (mask + 1) > kMaxFastContacts) mask = 2 * mask + 1;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = scratch.near_blocks[i];
    const bool is_deepest = at == walk.deepest_point / kBlock;
    if (!takes_all && ((at & mask) != 0 || count >= 2 * kMaxFastContacts) && !is_deepest) continue;
    const PointBlock& block = front.sampled.points[at];
    const float* const depths = scratch.depths(i);
    if (takes_all) {
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (depths[k] < -margin) continue;
        Place(front, block, k, depths[k] * voxel_m, &patches[count]);
        SetSums(block, k, depths[k] * voxel_m, &patches[count++]);
      }
      continue;
    }
    const std::uint32_t k = is_deepest ? walk.deepest_point % kBlock : FindDeepest(depths);
    Place(front, block, k, depths[k] * voxel_m, &patches[count]);
    SetSums(block, depths, voxel_m, &patches[count++]);
  }
  return count;
}

double CountEffective(const SampleTree& sampled, const FieldWalkResult& walk, const FieldWalkScratch& scratch) {
  // So many have the whole share anyway (BackShare), unless a few of them carry nearly all.
  if (walk.num_colliding > 4096) return walk.num_colliding;
  EffectiveCount count;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const PointBlock& block = sampled.points[scratch.near_blocks[i]];
    const float* const depths = scratch.depths(i);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      if (depths[k] > 0.0f) count.Add(static_cast<double>(block.area_m2[k]) * depths[k]);
    }
  }
  return count.value();
}

void Scale(std::span<ContactPatch> patches, double share) {
  const auto s = static_cast<float>(share);
  for (ContactPatch& patch : patches) {
    patch.force_m3 *= s;
    patch.moment_m4 *= s;
    patch.volume_m3 *= s;
    patch.square_m4 *= s;
  }
}

void TakeDeepest(const SampleTree& sampled, const FieldWalkResult& walk, const BackSide& back,
                 const FieldWalkResult& behind, const core::Pose& X_GS, PairResult* result) {
  if (behind.num_near == 0 || (walk.num_near > 0 && walk.deepest_m >= behind.deepest_m)) {
    const PointBlock& block = sampled.points[walk.deepest_point / kBlock];
    const std::uint32_t k = walk.deepest_point % kBlock;
    result->signed_distance_m = -walk.deepest_m;
    result->deepest_p_S = PointOf(block, k);
    result->deepest_n_S = {block.nx[k], block.ny[k], block.nz[k]};
    return;
  }
  // The place of S's surface nearest to the point of G.
  const FieldTransform T(core::Pose{}, *back.field);
  const glm::dvec3 p_G(PointOf(back.points->points[behind.deepest_point / kBlock], behind.deepest_point % kBlock));
  const glm::dvec3 p_S = X_GS.inverse() * p_G;
  const glm::dvec3 outwards(glm::normalize(SampleField(*back.field, T.ToVoxels(glm::vec3(p_S))).gradient));
  result->signed_distance_m = -behind.deepest_m;
  result->deepest_p_S = p_S + behind.deepest_m * outwards;
  result->deepest_n_S = -outwards;
}

}  // namespace

double QueryFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                     const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                     PairResult* result, const BackSide& back) {
  const std::uint32_t num_chunks =
      PrepareWalk(sampled, field, X_GS, pair.look_ahead_m, BestInstructionSet(), &scratch->walk);
  for (std::uint32_t i = 0; i < num_chunks; ++i) EvaluateChunk(&scratch->walk, i);
  return FinishFastPair(sampled, field, X_WS, X_GS, pair, rho, scratch, result, back);
}

double FinishFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                      const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                      PairResult* result, const BackSide& back) {
  const FieldWalkResult walk = FinishWalk(&scratch->walk);
  FieldWalkResult behind;
  behind.free_distance_m = walk.free_distance_m;
  if (back.is_used()) {
    behind = WalkField(*back.points, *back.field, X_GS.inverse(), pair.look_ahead_m, &scratch->back_walk);
  }
  result->counters = {walk.spheres_tested + std::uint64_t{behind.spheres_tested},
                      walk.points_tested + std::uint64_t{behind.points_tested},
                      walk.num_colliding + std::uint64_t{behind.num_colliding}};
  result->is_in_contact = walk.num_colliding + behind.num_colliding > 0;
  result->f_So_S = {};
  result->F_So_W = {};
  scratch->force_m3 = walk.force_m3;
  scratch->moment_m4 = walk.moment_m4;
  if (walk.num_near == 0 && behind.num_near == 0) {
    const double free_m = std::min(walk.free_distance_m, behind.free_distance_m);
    result->planes.clear();
    result->signed_distance_m = pair.look_ahead_m + free_m;
    return free_m;
  }
  TakeDeepest(sampled, walk, back, behind, X_GS, result);
  const Front front{sampled, field, FieldTransform(X_GS, field)};
  const std::span<ContactPatch> patches(scratch->patches);
  const std::uint32_t num_front = MakePatches(front, walk, scratch->walk, pair.look_ahead_m, patches.data());
  std::uint32_t num_back = 0;
  double volume_m3 = walk.volume_m3;
  double square_m4 = walk.square_m4;
  if (behind.num_near > 0) {
    const BackSum sum = SumBackSide(back, field, X_GS, behind, scratch->back_walk, pair.look_ahead_m,
                                    patches.subspan(num_front, kMaxFastContacts), &num_back);
    const double share = BackShare(CountEffective(sampled, walk, scratch->walk), sum.num_effective);
    Scale(patches.first(num_front), 1.0 - share);
    Scale(patches.subspan(num_front, num_back), share);
    scratch->force_m3 = (1.0 - share) * walk.force_m3 + share * sum.force_m3;
    scratch->moment_m4 = (1.0 - share) * walk.moment_m4 + share * sum.moment_m4;
    volume_m3 = (1.0 - share) * walk.volume_m3 + share * sum.volume_m3;
    square_m4 = (1.0 - share) * walk.square_m4 + share * sum.square_m4;
  }
  const double scale = AreaScale(volume_m3, square_m4, sampled.area_m2, rho);
  result->f_So_S = scale * PenetrationSum{scratch->force_m3, scratch->moment_m4};
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));
  const ContactLoad load{scratch->force_m3, scratch->moment_m4, volume_m3, scale * pair.stiffness_N_per_m};
  ReducePatches(patches.first(num_front + num_back), X_GS, load, pair.stiffness_N_per_m, pair.look_ahead_m,
                2.0 * field.voxel_size_m, &result->planes, 0.25 * field.voxel_size_m);
  return 0.0;
}

}  // namespace vps
