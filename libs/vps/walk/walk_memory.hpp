#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"

namespace vps {

enum class InstructionSet;
class FieldWalkScratch;

// Upper bound of how far any point of a ball of S has moved in G between two poses [m]. A turn by the angle a moves a
// point at distance r from its axis by 2 sin(a / 2) r, and sin(a / 2) is the length of the relative quaternion's
// vector.
double MotionBound(const core::Pose& X_GS_before, const core::Pose& X_GS_now, const glm::dvec3& centre_S,
                   double radius_m);

// Temporal coherence of one pair's walks, so that small motions cost less than the tree: while nothing was near, how
// far S may move; else a list of the blocks that can come near within a skin, each with how far S may move before it
// has to be tested. Both are compared with the motion since the pose at which they were found, so nothing drifts.
// Contact sums are bit for bit those of a walk that starts anew; free distances are lower bounds in both.
//
// Long lists are not made: in conforming contact the points cost more than the tree, and a list tests more of them.
// Neither are lists for motions so quick that they would not last.
class FieldWalkMemory {
 public:
  static constexpr std::uint32_t kMostBlocks = 4096;  // 32 KB; lists are made while a walk tests up to a quarter of it
  FieldWalkMemory() : blocks_(kMostBlocks), slacks_(kMostBlocks) {}

  // How far every point of S may still move before anything of this pair can come within the margin [m]; 0: unknown, a
  // walk is needed. Quick, for the many calls in which nothing is near; updates the memory as the walk would.
  double RemainingFreeDistance_m(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                                 double margin_m);
  // When the tree or the field it was used with is gone.
  void Forget() {
    sampled_ = nullptr;
    state_ = State::kNothing;
  }

 private:
  friend class FieldWalkScratch;
  friend std::uint32_t PrepareWalk(const SampleTree&, const DistanceField&, const core::Pose&, double, InstructionSet,
                                   FieldWalkScratch*);

  enum class State : std::uint8_t { kNothing, kApart, kList };
  struct Advice {
    enum { kStartAnew, kMakeList, kUseList, kStayApart } what;
    double voxels;  // kMakeList: the list's skin; kUseList: motion since it was made; kStayApart: free distance left
  };
  // Lists are made to last about four cycles of the present motion, with a skin of an eighth to half a voxel. Not
  // derived: a wide skin tests more points, a narrow one makes more lists; with these a light contact takes 1 / 1.4, 1
  // / 1.25 and 1 / 1.1 of the time at 0.01, 0.03 and 0.1 voxel per cycle (results of libs/vps, from cycle to cycle).
  static constexpr double kCyclesOfList = 4.0;
  static constexpr double kLeastSkin = 0.125;
  static constexpr double kWidestSkin = 0.5;
  // Error of a point's place in the walk's floats, voxels: twice BoundCells' allowance, at two poses.
  static constexpr double kRounding = 4e-3;

  [[nodiscard]] bool is_apart() const { return state_ == State::kApart; }
  Advice Advise(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m);
  [[nodiscard]] double FreeAtLeast(const core::Pose& X_GS) const;                 // voxels
  double Moved(const core::Pose& X_GS_before, const core::Pose& X_GS_now) const;  // voxels
  void KeepApart(double free_voxels);
  void KeepList(double skin_voxels, double free_voxels, std::span<const std::uint32_t> blocks, const float* slacks);
  // The blocks of the list that S's motion can have brought near, and how far it may go on before another one is.
  std::uint32_t Select(double moved_voxels, std::uint32_t* blocks, double* free_voxels) const;

  const SampleTree* sampled_ = nullptr;
  const DistanceField* field_ = nullptr;
  double margin_m_ = 0.0;
  double farthest_m_ = 0.0;       // any point of S from its mesh origin
  core::Pose X_GS_last_;          // of the last walk
  std::uint32_t num_tested_ = 0;  // blocks, by the last walk
  State state_ = State::kNothing;
  core::Pose X_GS_;           // at which the memory was made
  double free_voxels_ = 0.0;  // kApart: of all; kList: of the blocks that are not in it
  double skin_voxels_ = 0.0;
  std::uint32_t num_blocks_ = 0;
  std::vector<std::uint32_t> blocks_;  // ascending
  std::vector<float> slacks_;          // voxels
};

}  // namespace vps
