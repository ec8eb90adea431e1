#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

enum class InstructionSet { kPortable, kAvx2, kAvx512 };

// Results of all sets are the same bits. The widest that this processor and this build have.
// VR_OOS_SIMD=portable|avx2|avx512 asks for less.
InstructionSet BestInstructionSet();
[[nodiscard]] bool IsAvailable(InstructionSet set);

struct FieldWalkResult;
class FieldWalkMemory;

// Memory of walks, allocated once; serves this tree and smaller ones.
class FieldWalkScratch {
 public:
  explicit FieldWalkScratch(const SampleTree& tree);

  // What the walks that use this scratch remember of their pair from one to the next; null: nothing, each starts anew.
  FieldWalkMemory* memory = nullptr;
  // Budget of a walk that uses this scratch, points; 0: as many as it takes. If there are more to test, those blocks go
  // first that are deepest by estimate, 64 of them in any case, so that the deepest point stays; a larger budget tests
  // the same blocks and more, so what is missing of the integral of the depth only falls.
  std::uint32_t most_points = 0;
  // Whether walks that use this scratch end, without a chunk, when more than kBroadSpheres spheres of 256 points may
  // come near, found on the way to the points.
  bool ends_when_broad = false;
  static constexpr std::uint32_t kBroadSpheres = 48;

  // Blocks with a point within the margin, ascending, and where the depths of their points are.
  std::vector<std::uint32_t> near_blocks;
  std::vector<std::uint32_t> near_slots;
  struct alignas(64) Depths {
    float of[kBlock];  // voxels, positive inside
  };
  std::vector<Depths> near_depths;
  // Blocks whose points the last walk tested, ascending.
  [[nodiscard]] std::span<const std::uint32_t> tested_blocks() const {
    return {blocks_, num_chunks_ > 0 ? chunks_[num_chunks_ - 1].end : 0};
  }
  // Of the last walk: whether the budget ran out, and how many points it would have tested without one.
  [[nodiscard]] bool is_cut_short() const { return is_cut_short_; }
  [[nodiscard]] std::uint32_t points_due() const { return points_due_; }
  [[nodiscard]] bool is_broad() const { return is_broad_; }
  [[nodiscard]] const float* depths(std::uint32_t near) const { return near_depths[near_slots[near]].of; }

 private:
  friend std::uint32_t PrepareWalk(const SampleTree&, const DistanceField&, const core::Pose&, double, InstructionSet,
                                   FieldWalkScratch*);
  friend void EvaluateChunk(FieldWalkScratch*, std::uint32_t);
  friend FieldWalkResult FinishWalk(FieldWalkScratch*);
  friend bool IsBroadInside(FieldWalkScratch*, double);
  struct Chunk {
    std::uint32_t begin, end;  // in blocks_
    WalkSums sums;
  };
  std::vector<std::uint32_t> queue_;
  std::vector<float> bounds_;              // of the blocks found: slacks or least distances, voxels
  std::vector<std::uint32_t> chunk_near_;  // near blocks of each chunk, from its begin
  std::vector<Chunk> chunks_;
  std::uint32_t chunk_shift_ = 0;  // a chunk holds blocks whose numbers differ only in so many last bits
  std::uint32_t num_chunks_ = 0;
  std::uint32_t* blocks_ = nullptr;  // in queue_
  WalkInput input_{};
  WalkKernels kernels_{};
  std::uint32_t FindBlocks(float* kept = nullptr, float skin = 0.0f);
  std::uint32_t ListBlocks(double skin_voxels);
  bool IsFarApart();
  void RememberApart(double free_voxels) const;
  std::uint32_t PickDeepest(std::uint32_t most_blocks);
  void CutIntoChunks(std::uint32_t num_blocks);

  double voxel_size_m_ = 0.0;
  std::uint32_t spheres_tested_ = 0;
  bool is_cut_short_ = false;
  bool is_broad_ = false;
  std::uint32_t points_due_ = 0;
  double room_ = 0.0;  // of what was culled, voxels
};

// Integrals of powers of the depth over S's surface inside G are continuous in the pose also as sums over points; the
// area in contact is not: a point that comes in brings its area at once.
//
// The penalty integral over S's surface inside G, depth times inward normal dA, by quadrature over the samples; about
// S's mesh origin, in S.
struct FieldWalkResult {
  glm::dvec3 force_m3{0.0};
  glm::dvec3 moment_m4{0.0};
  double volume_m3 = 0.0;             // integral of the depth
  double square_m4 = 0.0;             // integral of its square
  double deepest_m = -1e30;           // of the near points: penetration, negative when apart
  std::uint32_t deepest_point = 0;    // block * 16 + lane
  std::uint32_t num_near_blocks = 0;  // valid entries in the scratch
  std::uint32_t num_near = 0;         // points within the margin
  std::uint32_t num_colliding = 0;
  std::uint32_t num_inside = 0;  // of these, in blocks that collide with all of their points: not at a contact's rim
  std::uint32_t spheres_tested = 0;
  std::uint32_t points_tested = 0;
  bool is_cut_short = false;     // the budget ran out: sums and near points are of the blocks tested
  double free_distance_m = 0.0;  // nothing near: S may move so far, every point of it, before something can be
};

// Tests the tree's spheres level by level against the field (one vector instruction for all children of a node) and
// the points of every block whose sphere comes within `margin_m` of G. Does not allocate.
FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, FieldWalkScratch* scratch);
FieldWalkResult WalkField(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, InstructionSet set, FieldWalkScratch* scratch);

// The same in parts, so that several workers can share one heavy pair: PrepareWalk returns a number of chunks, each of
// which one thread must evaluate, in any order; FinishWalk adds them up in theirs. The result does not depend on who
// evaluated what. The tree, field and scratch must stay as they are from the first to the last. None allocates.
std::uint32_t PrepareWalk(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                          double margin_m, InstructionSet set, FieldWalkScratch* scratch);
void EvaluateChunk(FieldWalkScratch* scratch, std::uint32_t chunk);
FieldWalkResult FinishWalk(FieldWalkScratch* scratch);

// Between PrepareWalk and its chunks: whether of every seventh block that they would test at least so many collide with
// all points.
bool IsBroadInside(FieldWalkScratch* scratch, double least);

// The reference: every point, one after the other, with SampleField.
FieldWalkResult WalkFieldFlat(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                              double margin_m);

// Point of S in G's voxels, and the direction from there.
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
