#include "vps/multibody/fast_pair_query.hpp"

#include <algorithm>

namespace vps {
namespace {

SampledContact MakeContact(const SampleTree& sampled, const DistanceField& field, const FieldTransform& T,
                           const glm::mat3& R_SG, std::uint32_t point, float depth_voxels) {
  const PointBlock& block = sampled.points[point / kBlock];
  const std::uint32_t k = point % kBlock;
  SampledContact contact;
  contact.p_S = {block.x[k], block.y[k], block.z[k]};
  // The gap's derivative is the field's gradient; the point's own normal is 45 degrees off at an edge.
  contact.n_S = R_SG * glm::normalize(SampleField(field, T.ToVoxels(contact.p_S)).gradient);
  contact.penetration_m = depth_voxels * static_cast<float>(field.voxel_size_m);
  return contact;
}

}  // namespace

double QueryFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                     const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                     PairResult* result) {
  const std::uint32_t num_chunks =
      PrepareWalk(sampled, field, X_GS, pair.look_ahead_m, BestInstructionSet(), &scratch->walk);
  for (std::uint32_t i = 0; i < num_chunks; ++i) EvaluateChunk(&scratch->walk, i);
  return FinishFastPair(sampled, field, X_WS, X_GS, pair, rho, scratch, result);
}

double FinishFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                      const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                      PairResult* result) {
  const FieldWalkResult walk = FinishWalk(&scratch->walk);
  result->counters = {walk.spheres_tested, walk.points_tested, walk.num_colliding};
  result->is_in_contact = walk.num_colliding > 0;
  result->f_So_S = {};
  result->F_So_W = {};
  scratch->force_m3 = walk.force_m3;
  scratch->moment_m4 = walk.moment_m4;
  if (walk.num_near == 0) {
    result->planes.clear();
    result->signed_distance_m = pair.look_ahead_m + walk.free_distance_m;
    return walk.free_distance_m;
  }
  result->signed_distance_m = -walk.deepest_m;
  const PointBlock& deepest_block = sampled.points[walk.deepest_point / kBlock];
  const std::uint32_t deepest_lane = walk.deepest_point % kBlock;
  result->deepest_p_S = {deepest_block.x[deepest_lane], deepest_block.y[deepest_lane], deepest_block.z[deepest_lane]};
  result->deepest_n_S = {deepest_block.nx[deepest_lane], deepest_block.ny[deepest_lane],
                         deepest_block.nz[deepest_lane]};
  result->f_So_S =
      AreaScale(walk.volume_m3, walk.square_m4, sampled.area_m2, rho) * PenetrationSum{walk.force_m3, walk.moment_m4};
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));

  const FieldTransform T(X_GS, field);
  const glm::mat3 R_SG(glm::mat3_cast(glm::conjugate(X_GS.rotation)));
  const bool takes_all = walk.num_near <= kMaxFastContacts;
  std::uint32_t mask = 0;
  while (walk.num_near_blocks / (mask + 1) > kMaxFastContacts) mask = 2 * mask + 1;
  const auto margin = static_cast<float>(pair.look_ahead_m / field.voxel_size_m);
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t block = scratch->walk.near_blocks[i];
    const float* const depths = scratch->walk.depths(i);
    if (takes_all) {
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (depths[k] < -margin) continue;
        scratch->contacts[count++] = MakeContact(sampled, field, T, R_SG, block * kBlock + k, depths[k]);
      }
      continue;
    }
    const bool is_deepest = block == walk.deepest_point / kBlock;
    if (((block & mask) != 0 || count >= 2 * kMaxFastContacts) && !is_deepest) continue;
    const std::uint32_t k =
        is_deepest ? deepest_lane : static_cast<std::uint32_t>(std::max_element(depths, depths + kBlock) - depths);
    scratch->contacts[count++] = MakeContact(sampled, field, T, R_SG, block * kBlock + k, depths[k]);
  }
  ReduceContacts({scratch->contacts.data(), count}, X_GS, pair.stiffness_N_per_m, pair.look_ahead_m, &result->planes,
                 0.25 * field.voxel_size_m);
  return 0.0;
}

}  // namespace vps
