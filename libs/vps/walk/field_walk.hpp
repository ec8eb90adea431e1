#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

enum class InstructionSet { kPortable, kAvx2, kAvx512 };

// The widest set that this processor and this build have, or the smaller one of VR_OOS_SIMD=portable|avx2|avx512. All
// sets give the same bits, but for one rounding in 2^29 of the portable one.
InstructionSet BestInstructionSet();
[[nodiscard]] bool IsAvailable(InstructionSet set);
// The kernels that were compiled for `set`; portable ones where the machine is another.
WalkKernels KernelsOf(InstructionSet set);

struct FieldWalkMemory;

// The penalty integral over the part of S's surface inside G, by quadrature over the samples i with weights A_i (area),
// depths d_i > 0 and inward normals n_i, at places p_i; about S's mesh origin, in S:
//
//   force  = integral of d n dA      = sum A_i d_i n_i         [m^3]
//   moment = integral of p x d n dA  = sum p_i x A_i d_i n_i   [m^4]
//
// Integrals of powers of the depth are continuous in the pose also as sums over points; the area in contact is not: the
// area of a point counts at once when it comes in.
struct FieldWalkResult {
  glm::dvec3 force_m3{0.0};
  glm::dvec3 moment_m4{0.0};
  double volume_m3 = 0.0;  // integral of the depth
  double square_m4 = 0.0;  // integral of its square
  // Standard deviation of what the samples miss of the integral of the depth. max(d, 0) at a sample is less than the
  // mean over a cell that the zero level cuts, by e_i >= 0 (AddMissed in walk_points.hpp), in the mean over all
  // positions of the cell. Their sum is what the samples miss then; it scatters by about the root of the sum of
  // their squares if each cell lies by chance. Neighbours along the border of a contact lie alike for a while: the
  // geometric mean of the two is taken,
  //
  //   sqrt(sum e_i sqrt(sum e_i^2)).
  double missed_m3 = 0.0;
  double deepest_m = -1e30;           // of the near points: penetration, negative when apart
  std::uint32_t deepest_point = 0;    // block * 16 + lane
  std::uint32_t num_near_blocks = 0;  // valid entries in the scratch
  std::uint32_t num_near = 0;         // points within the margin
  std::uint32_t num_colliding = 0;
  std::uint32_t spheres_tested = 0;
  std::uint32_t points_tested = 0;
  std::uint32_t points_due = 0;  // that it would have tested without a budget
  bool is_cut_short = false;     // the budget ran out: sums and near points are of the blocks tested
  double free_distance_m = 0.0;  // nothing near: every point of S may move so far before one can be near
};

// Walks, with their memory, allocated once; serves this tree and smaller ones.
class FieldWalkScratch {
 public:
  explicit FieldWalkScratch(const SampleTree& tree, InstructionSet set = BestInstructionSet());

  // Memory of the pair from one walk to the next; null: each walk starts anew.
  FieldWalkMemory* memory = nullptr;
  // Budget of a walk that uses this scratch, points; 0: unlimited. If there are more to test, the blocks that are
  // deepest by estimate are tested, at least 64 of them, so that the deepest point stays; a larger budget tests the
  // same blocks and more, so that the missing part of the integral of the depth only shrinks.
  std::uint32_t most_points = 0;

  // A walk in parts, so that several workers can share one heavy pair: Prepare returns a number of chunks, each of
  // which one thread must evaluate, in any order; Finish adds them up in theirs. The result does not depend on who
  // evaluated what. The tree and the field must stay as they are from the first to the last. None allocates.
  std::uint32_t Prepare(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m);
  void Evaluate(std::uint32_t chunk) { kernels_.evaluate(input_, &chunks_[chunk]); }
  FieldWalkResult Finish();

  // Of the last walk: blocks with a point within the margin, ascending, and the mean depths of their points, voxels,
  // positive inside.
  std::vector<std::uint32_t> near_blocks;
  [[nodiscard]] const float* depths(std::uint32_t near) const { return near_depths_[near_slots_[near]].of; }

 private:
  struct alignas(64) Depths {
    float of[kBlock];
  };
  void FindBlocks(float* estimates = nullptr);
  void PickDeepest(std::uint32_t most_blocks);

  std::vector<std::uint32_t> queue_;
  std::vector<float> estimates_;       // of the blocks found: least distances, voxels
  std::vector<std::uint32_t> picked_;  // numbers of those, the deepest first
  std::vector<std::uint32_t> near_slots_;
  std::vector<Depths> near_depths_;
  std::vector<WalkChunk> chunks_;
  WalkKernels kernels_;
  WalkInput input_{};
  std::uint32_t* blocks_ = nullptr;  // in queue_
  std::uint32_t num_blocks_ = 0;
  std::uint32_t num_chunks_ = 0;
  double voxel_size_m_ = 0.0;
  double free_distance_ = 0.0;  // of what was culled, voxels
  FieldWalkResult result_;
};

// Tests the tree's spheres level by level against the field (one vector instruction for all children of a node) and
// the points of every block whose sphere may come within `margin_m` >= 0 of G. X_GS: pose of S in G. Does not allocate.
FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, FieldWalkScratch* scratch);

// The field's part of a kernel's input, with the transform of the points; everything else is zero.
WalkInput MakeFieldInput(const DistanceField& field, const core::Pose& X_GS);

// A point of S (mesh frame, m) in G's voxels.
struct FieldTransform {
  FieldTransform(const core::Pose& X_GS, const DistanceField& field);
  float m[3][3];
  float t[3];
  [[nodiscard]] glm::vec3 ToVoxels(const glm::vec3& p_S) const {
    return {m[0][0] * p_S.x + m[0][1] * p_S.y + m[0][2] * p_S.z + t[0],
            m[1][0] * p_S.x + m[1][1] * p_S.y + m[1][2] * p_S.z + t[1],
            m[2][0] * p_S.x + m[2][1] * p_S.y + m[2][2] * p_S.z + t[2]};
  }
};

}  // namespace vps
