#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collision/owned_world.hpp"
#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "nodes/haptic_node/contact_books.hpp"
#include "nodes/haptic_node/ports.hpp"
#include "scene/scenario.hpp"
#include "vps/coupling/virtual_coupling.hpp"
#include "vps/multibody/collision_world.hpp"

namespace haptic_node {

struct Options {
  collision::Options collision;
  std::int64_t budget_ns =
      0;  // for collision in one step; 0: no limit, so results do not depend on the machine's speed
};

// A source is stale after this time without a message, by this node's clock. Its force then fades out within kFade and,
// when messages return, fades in within five times that. 20 + 20 ms keeps below the limit of 60 ms for a force without
// a source (safety_filter.hpp) with 20 ms to spare. How the 40 ms are shared is a free choice: a shorter wait takes a
// pause of the network for the end, a shorter fade is felt as a step. A device's own samples cross no network: half.
constexpr std::int64_t kPhysicsStale_ns = 20'000'000;
constexpr std::int64_t kDeviceStale_ns = 10'000'000;
constexpr std::int64_t kFade_ns = 20'000'000;

// Computes the collision of all pairs of haptic_node, the force on each hand, and the contacts for each object.
//
// Every step: parameters, poses (objects from physics/state, hand parts at the proxy pose C), collision of the active
// pairs, then per hand the virtual coupling [VR-OOS, Eq. 3-6], the force on the jaws, the reaction from physics, and
// the force limit. Step neither allocates, locks, throws nor logs, and its results do not depend on the number of
// workers.
class HapticNode {
 public:
  // Cooks the structures of every object that can collide, or loads them from the cache. `workers` must outlive the
  // node. Errors: kUnsupported for too many devices, and those of cooking.
  static core::Result<std::unique_ptr<HapticNode>> Create(const scene::Scenario& scenario, core::ParallelFor& workers,
                                                          const Options& options);

  // Allocates one slot per pair; call it once, before the first Step.
  void PrepareOutputs(Outputs* outputs) const;
  void Step(const Inputs& inputs, Outputs* outputs) noexcept;

  // The commands anew when physics has answered, without another collision query (decision 18): the last cycle's planes
  // at the poses of the answer, its reactions and the newest samples, and what the coupling makes of them. Nothing is
  // kept: a Step after it is the same as without it. A command is to be sent when its trace has come through physics.
  void Reevaluate(const Inputs& inputs, Outputs* outputs) const noexcept;
  // Whether state and reactions are of one tick of physics, with a hand in contact with something that physics moves.
  [[nodiscard]] bool IsToReevaluate(const Inputs& inputs) const;

  // Names of this node's parameters; whether it has the parameter and accepts the value.
  [[nodiscard]] std::vector<std::string> ParameterNames() const;
  [[nodiscard]] bool AcceptsParameter(const core::ParameterChange& change) const;
  [[nodiscard]] std::uint64_t cycle() const { return cycle_; }
  // Share of the scenario's stiffness that the couplings have, the smallest of all hands, now and since the beginning:
  // 1 while the delay of the loop allows it.
  [[nodiscard]] double stiffness_share() const;
  [[nodiscard]] double least_stiffness_share() const { return least_stiffness_share_; }
  // Of the damper of a role's coupling: of a tool with mass, as it wants to be, but no more than the limit.
  [[nodiscard]] double damping_N_s_per_m(std::size_t role) const {
    return roles_[role].god_object ? roles_[role].god_object->damping_N_s_per_m() : 0.0;
  }
  // Pairs in each state, by vps::PairState.
  [[nodiscard]] std::array<std::uint32_t, vps::kNumPairStates> CountPairs() const { return world_->CountStates(); }

 private:
  // Time since a message last changed, by this node's clock; publishers' clocks do not matter.
  struct Freshness {
    std::uint64_t sequence = 0;
    std::int64_t seen_ns = 0;
    void Update(std::uint64_t now_sequence, std::int64_t now_ns) {
      if (now_sequence == sequence) return;
      sequence = now_sequence;
      seen_ns = now_ns;
    }
    [[nodiscard]] bool has_arrived() const { return sequence != 0; }
    [[nodiscard]] bool is_stale(std::int64_t now_ns, std::int64_t limit_ns) const {
      return now_ns - seen_ns > limit_ns;
    }
  };

  struct Role {
    scene::Device device;
    bool has_fingers = false;
    std::vector<std::uint8_t> is_hand_part;  // per object
    vps::VirtualCoupling coupling;
    std::optional<vps::GodObject> god_object;  // in place of it
    core::DeviceState sample;                  // newest
    Freshness device_freshness;
    Freshness reaction_freshness;
    bool is_following = false;  // the coupling is active; false: C equals D
    double reaction_gain = 0.0;
    double stiffness_limit = 1.0;  // share of the scenario's stiffness
    double stiffness_share = 1.0;  // follows the limit
    core::Reaction reaction;
    vps::CouplingContact contact;
    vps::ToolContact tool_contact;
    bool is_in_contact = false;
    core::Wrench F_Do_W;  // of the coupling
    ContactBooks books;
    glm::dvec3 objects_N{0.0};   // of F_Do_W, what objects of physics make
    double objects_share = 0.0;  // of F_Do_W when it was last not zero
    std::size_t owing_pair = 0;  // of the strongest of these contacts, also when it is over
    std::uint16_t owing_object = core::kNoObject;
    glm::dvec3 p_O_owing{0.0};      // its place on the object
    double sum_of_weights_m = 0.0;  // sum of |penetration sum| over the pairs of the coupling
    std::uint64_t last_trace_through_physics = 0;

    [[nodiscard]] const core::Pose& X_WC() const { return god_object ? god_object->X_WC() : coupling.X_WC(); }
    void Reset(const core::Pose& X_WD) { god_object ? god_object->Reset(X_WD) : coupling.Reset(X_WD); }
  };

  // Role of a pair of this node's world. A pair of two hands enters both couplings and is not published.
  struct PairRole {
    std::uint16_t scenario_pair = 0;
    int sampled_role = -1;  // role whose hand S is part of
    int field_role = -1;
    bool is_published = false;  // for physics_node and viewers
    int empty_sets_left = 0;    // still to send after the contact has ended
  };

  HapticNode(const scene::Scenario& scenario, core::ParallelFor& workers, const Options& options);
  core::Result<void> BuildWorld();
  void BuildPairRoles(const std::vector<std::uint16_t>& scenario_pairs);
  void BuildRoles(const collision::OwnedWorld& owned);
  [[nodiscard]] int RoleOf(std::uint16_t object) const;
  [[nodiscard]] const scene::Pair& PairOf(std::size_t pair) const {
    return scenario_.pairs[pair_roles_[pair].scenario_pair];
  }
  [[nodiscard]] bool IsHeld(const PairRole& pair_role, std::size_t pair) const;
  [[nodiscard]] static int IgnoredObject(const core::Reaction& reaction, double gain);
  // Fingers hold by their contacts, and the palm touches what they hold as anything else.
  [[nodiscard]] static int IgnoredObject(const Role& role) {
    return role.has_fingers ? -1 : IgnoredObject(role.reaction, role.reaction_gain);
  }

  void ApplyChange(const core::ParameterChange& change);
  void UpdateDevices(const Inputs& inputs);
  void UpdatePhysics(const Inputs& inputs);
  void UpdateDelay(const core::Trace& sample);
  void PlaceObjects();
  const vps::StepReport& StepWorld(std::uint64_t budget_points, Counters* counters);
  [[nodiscard]] bool IsDampingLimit(const std::string& name) const;
  void LimitDamping(const core::ParameterChange& change);
  void LimitStiffness(Role* role, std::int64_t elapsed_ns);
  void StepCoupling(Role* role);
  void KeepBooks(Role* role) const;
  // The force of `role` if its paper's coupling made a step with the planes at `moved_X_WO_`.
  [[nodiscard]] core::Wrench PreviewCoupling(const Role& role, const core::Pose& X_WD, int ignored_object) const;
  [[nodiscard]] core::DeviceCommand ReevaluateRole(std::size_t role_index, const Inputs& inputs) const;
  [[nodiscard]] core::DeviceCommand MakeCommand(std::size_t role_index, const core::Header& header,
                                                const core::Wrench& F_coupling_Do_W, const core::Wrench& F_rest_Do_W,
                                                double grip_force_N) const;
  [[nodiscard]] bool HasField(const Role& role) const;
  void MoveObjects(const Inputs& inputs) const;
  // Normal force of a jaw on what it touches.
  [[nodiscard]] double JawPress_N(std::size_t pair, std::span<const core::Pose> moved_X_WO = {}) const;
  [[nodiscard]] double JawForce_N(std::size_t role_index, std::span<const core::Pose> moved_X_WO = {}) const;
  void FillRoleOutputs(std::size_t role_index, const Inputs& inputs, Outputs* outputs);
  void FillContacts(const Inputs& inputs, Outputs* outputs);
  void FillCollisions(Outputs* outputs) const;
  void ShareHandContact(std::size_t pair, const PairRole& pair_role, core::ContactSet* set) const;
  [[nodiscard]] core::Pose PoseAtD(const Role& role, std::uint16_t object) const;
  void WriteToolContact(std::size_t pair, const Role& role, bool is_hand_sampled, core::ContactSet* set) const;

  scene::Scenario scenario_;
  core::ParallelFor& workers_;
  Options options_;
  std::unique_ptr<vps::CollisionWorld> world_;
  std::vector<Role> roles_;
  std::vector<PairRole> pair_roles_;                // per pair of the world, as are the next two
  std::vector<std::string> stiffness_limit_names_;  // per role, as are the next two
  std::vector<std::string> damping_limit_names_;    // empty text: its tool has no damping
  std::vector<std::string> turn_damping_limit_names_;
  std::vector<std::string> pair_active_names_;     // "pair.<a>/<b>.active"
  std::vector<std::string> pair_stiffness_names_;  // "pair.<a>/<b>.stiffness_N_per_m"
  std::vector<core::Pose> X_WO_;
  std::vector<core::Twist> V_WO_;
  mutable std::vector<core::Pose> moved_X_WO_;  // scratch of Reevaluate: where the objects are by now
  mutable std::vector<core::Twist> moved_V_WO_;
  Freshness physics_freshness_;
  double delay_cycles_ = 0.0;  // bound of the delay from a pose to the use of planes computed from it
  double physics_gain_ = 1.0;  // 0: physics_node is silent
  double force_cap_N_ = 0.0;
  double least_stiffness_share_ = 1.0;
  std::int64_t last_step_ns_ = 0;
  double point_time_ns_ = 10.0;  // time per point; the initial value is high, so that the first steps keep the budget
  std::uint64_t cycle_ = 0;
};

}  // namespace haptic_node
