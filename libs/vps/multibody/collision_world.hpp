#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/messages/haptic.hpp"
#include "core/parallel_for.hpp"
#include "core/pose.hpp"
#include "core/result.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/coupling/god_object.hpp"
#include "vps/coupling/virtual_coupling.hpp"
#include "vps/force/penetration_sum.hpp"
#include "vps/multibody/touch_memory.hpp"

namespace vps {

struct ObjectDescription {
  std::shared_ptr<const CookedObject> data;  // null: never collides
  core::Pose X_WO;
};

// S's points against G's field. Groups are resolved into pairs by libs/scene. Defaults are those of scenarios that set
// nothing (most_places: their 60 us, rounded); not derived.
struct PairDescription {
  std::uint16_t sampled = 0;
  std::uint16_t field = 0;
  double stiffness_N_per_m = 2.0e4;
  double damping_N_s_per_m = 20.0;
  double friction = 0.2;
  double look_ahead_m = 0.002;
  // `fast`: wanted error of the force over the integral of depth, and the most places of G's field that are read for it
  // (SurfaceWalk). An error of negligible_N does not count: no hand feels it. Reached is PairResult::force_error_N.
  double accuracy = 0.1;
  double negligible_N = 0.01;
  std::uint32_t most_places = 2048;
  bool is_active = true;
  // `fast`: of a tool that rests on the surface (GodObject). Planes are exact gaps of single places instead of loads.
  bool has_gaps = false;
};

struct WorldDescription {
  std::vector<ObjectDescription> objects;
  std::vector<PairDescription> pairs;
  double rho = 0.01;  // Eq. 2
  double alpha = 2.0;
  Method method = Method::kPaper;  // of all pairs; objects must have been cooked for it
};

// Work of one query or one step: exact integers, the same for any number of workers.
struct QueryCounters {
  std::uint64_t spheres_tested = 0;
  std::uint64_t points_tested = 0;
  std::uint64_t points_colliding = 0;
};

// Newest result of a pair. Frames: S sampled object, G field object.
struct PairResult {
  std::uint64_t cycle = 0;  // cycle at which it was computed; 0: never
  bool is_in_contact = false;
  bool is_cut_short = false;       // `fast`: less accurate than wanted: a budget ran out
  double signed_distance_m = 1e9;  // -p when in contact, tight within the look-ahead. Apart: see the world's
  PenetrationSum f_So_S;           // scaled by lambda (Eq. 1, 2) or AreaScale, about S's mesh origin, in S
  double force_error_N = 0.0;      // `fast`: estimate of |F_So_W - the exact one|
  core::Wrench F_So_W;             // stiffness times that, in W: the paper's wrench on S; G gets the opposite
  core::FixedVector<core::ContactPlane, core::kMaxContactPlanes> planes;
  QueryCounters counters;
};

// Stages of the broad and narrow phase, by cost. Inactive: switched off by the state matrix. Asleep: neither object has
// moved, nothing is done. Far: the bounding spheres of the two objects bound their distance. Near: their trees bound
// it, or points are within the look-ahead. Contact.
enum class PairState : std::uint8_t { kInactive, kAsleep, kFar, kNear, kContact };
constexpr std::size_t kNumPairStates = 5;

// Voxels; a plane keeps its place unless another one is better by more. Not derived.
constexpr double kHysteresis = 0.25;

// What CollisionWorld keeps of a pair from cycle to cycle.
struct PairMemory {
  PairResult result;
  core::Pose X_GS;          // of the result
  bool is_current = false;  // the result belongs to this pose and the present description
  PairState state = PairState::kFar;
  double free_m = 0.0;  // motion until it has to be tested again; 0: it is tested in every cycle
  TouchMemory touch;
};

struct StepReport {
  std::uint32_t pairs_considered = 0;
  std::uint32_t pairs_inactive = 0;   // by state matrix
  std::uint32_t pairs_coherent = 0;   // not tested: motion since the last test is less than the distance found then
  std::uint32_t pairs_bounded = 0;    // the spheres around the two objects were compared, and are apart
  std::uint32_t pairs_unchanged = 0;  // relative pose bitwise the same: the result was kept
  std::uint32_t pairs_tested = 0;     // by their trees
  std::uint32_t pairs_in_contact = 0;
  std::uint32_t pairs_cut_short = 0;       // tested, less accurately than wanted: a budget ran out
  std::uint32_t pairs_late = 0;            // deferred to the next cycle: out of time
  std::uint32_t oldest_result_cycles = 0;  // greatest age of a result that should have been renewed
  QueryCounters counters;                  // of the pairs tested in this step
};

// The multi-object framework of VR-OOS, Fig. 8 and 9. Create it with everything that can collide; then once per cycle
// set poses and Step. Step neither allocates, locks nor throws.
//
// Coherence: a pair that was found apart is not tested again until the real displacements of its two objects, rotation
// included, have used up the distance found (PairSchedule). No speed is assumed, so a contact cannot be late.
class CollisionWorld {
 public:
  static core::Result<std::unique_ptr<CollisionWorld>> Create(const WorldDescription& description);
  ~CollisionWorld();

  void SetPose(std::size_t object, const core::Pose& X_WO);
  void SetActive(std::size_t pair, bool is_active);  // state matrix
  void SetStiffness(std::size_t pair, double stiffness_N_per_m);
  // Cycles from a pose to the use of planes made from it. From then on, with the method of the paper, a pair's
  // look-ahead follows its speed: once, twice or four times the pair's own, so that it holds what the fastest points of
  // both objects cover in the delay and two cycles, if four times do.
  void SetDelay(double delay_cycles);
  // A pair's result depends on its last ones: planes keep their ids and places, `fast` what sufficed. A world that
  // continues another one gets the other's Memory for each pair that is active in both, after its objects have the
  // poses of the other's last Step. Not of pairs with gaps.
  [[nodiscard]] PairMemory Memory(std::size_t pair) const;
  void Continue(std::size_t pair, const PairMemory& memory);
  [[nodiscard]] const core::Pose& X_WO(std::size_t object) const;
  [[nodiscard]] bool is_active(std::size_t pair) const;

  // Budget 0: every due pair is tested. Otherwise the pairs with the oldest results go first; those that run out of
  // time keep their old result, its age counted. `budget_points`, of `fast`: the points that may be tested in this
  // step, shared among the due pairs in proportion to what each of them had to test last
  // (FieldWalkScratch::most_points); 0: unlimited.
  const StepReport& Step(core::ParallelFor* workers, std::int64_t budget_ns = 0, std::uint64_t budget_points = 0);

  [[nodiscard]] std::size_t num_objects() const;
  [[nodiscard]] std::size_t num_pairs() const;
  [[nodiscard]] const PairDescription& pair(std::size_t pair) const;
  [[nodiscard]] const PairResult& result(std::size_t pair) const;
  // Now: result(pair)'s while it has planes; when apart a lower bound, less what the two objects have moved since.
  [[nodiscard]] double signed_distance_m(std::size_t pair) const;
  [[nodiscard]] PairState state(std::size_t pair) const;
  // Pairs in each state; goes through all pairs, so rather for reports than for every cycle.
  [[nodiscard]] std::array<std::uint32_t, kNumPairStates> CountStates() const;
  // True when result(pair) was computed (or confirmed as unchanged) by the last Step.
  [[nodiscard]] bool is_fresh(std::size_t pair) const;
  // Penalty wrench summed over the object's active pairs in pair order, about its mesh origin, in W.
  [[nodiscard]] const core::Wrench& ObjectWrench(std::size_t object) const;

  // All contacts of one hand, for VirtualCoupling: sums over the active pairs in which exactly one side is
  // marked in `is_hand_part` (num_objects entries), about the hand frame's origin at X_WC. Pairs with `ignored_object`
  // (-1: none) are left out: an object that the hand holds is felt through the grasp spring, not through the coupling.
  // `moved_X_WO`: where the objects are by now, if not at the poses of the last Step. Planes and depths are taken there
  // without another query; the sums keep their direction in S.
  void HandContact(const std::vector<std::uint8_t>& is_hand_part, const core::Pose& X_WC, CouplingContact* contact,
                   int ignored_object = -1, std::span<const core::Pose> moved_X_WO = {}) const;
  // Deepest penetration of a pair in contact, likewise: that of the last Step and what its deepest plane has moved.
  [[nodiscard]] double Depth_m(std::size_t pair, std::span<const core::Pose> moved_X_WO = {}) const;

  // The same for GodObject, with an id for each plane of each pair. A plane's point is that of the hand.
  void HandPlanes(const std::vector<std::uint8_t>& is_hand_part, ToolContact* contact, int ignored_object = -1,
                  std::span<const core::Pose> moved_X_WO = {}) const;
  static std::uint32_t HandPlaneId(std::size_t pair, const core::ContactPlane& plane);
  // The contact with this id carries a force: its place stays among the planes although others may be nearer.
  void KeepHandPlane(std::uint32_t id);
  static std::size_t PairOfHandPlane(std::uint32_t id) { return id >> 16U; }

  // Payload of contacts/<source>/<pair>; the header is left alone.
  void FillContactSet(std::size_t pair, core::ContactSet* message) const;

  // Half a voxel of the pair's field: how deep VirtualCoupling lets a hand rest in this pair.
  [[nodiscard]] double RestPenetration_m(std::size_t pair) const;

 private:
  struct Impl;
  explicit CollisionWorld(std::unique_ptr<Impl> impl);
  // Lower bound of the distance of everything that the pair's planes do not stand for.
  [[nodiscard]] double ApartAtLeast_m(std::size_t pair) const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vps
