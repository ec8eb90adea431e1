#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/parallel_for.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/scenario.hpp"
#include "tools/failures/hand_energy.hpp"

namespace failures {

struct LoopOptions {
  std::string script;  // of the simulated operator, without its step line
  double tremor_m = 0.0;
  std::uint64_t seed = 1;
  int command_delay_ticks = 0;      // from haptic_node to the bridge
  int physics_delay_ticks = 0;      // from haptic_node to physics_node: contacts and proxies
  std::uint64_t budget_points = 0;  // of haptic_node's collision; 0: no limit
  std::int64_t budget_ns = 0;       // of haptic_node's step, as when it runs live; 0: no limit
  bool is_made_passive = true;      // by the bridge's passivity controller
  // In place of haptic_node: the force on the hand in closed form.
  std::function<core::Wrench(const core::DeviceState&)> answer;
};

// A command is in the arm this long after the sample that it was made from, as on one fast machine, unless it is
// delayed. Not at once: the safety filter lets a force change by so much in a time, and not at all in none.
constexpr std::int64_t kAnswer_ns = 300'000;

// The steps of device_bridge, haptic_node and, if the scene has bodies, physics_node, in turn on a virtual clock of
// 1 ms. Poses of bodies arrive one tick later.
class Loop {
 public:
  explicit Loop(const scene::Scenario& scenario, const LoopOptions& options = {});

  // One tick: the bridge moves the hand as the operator's script says.
  void Tick();
  // One tick in place of the bridge: the devices are at these poses.
  void Tick(std::span<const core::Pose> X_WDs) { Prescribe(X_WDs, true); }
  void Tick(const core::Pose& X_WD) { Prescribe({&X_WD, 1}, true); }
  // Of the prescribed hands' jaws, from the next tick on.
  void SetOpening(double opening_m) { opening_m_ = opening_m; }
  // The same, with the dead-man switch released: the tool is put where the device is.
  void LetGo(const core::Pose& X_WD) { Prescribe({&X_WD, 1}, false); }
  void Run(double seconds);

  [[nodiscard]] double now_s() const { return 1e-9 * static_cast<double>(now_ns_); }
  [[nodiscard]] const core::DeviceState& device() const { return devices_[0]; }
  // On the hand: what haptic_node has answered; what the arm exerts now, late and after the safety filter.
  [[nodiscard]] const core::Wrench& command() const { return out_.commands[0].F_Do_W; }
  [[nodiscard]] core::Wrench exerted() const;
  // From now on no command arrives.
  void CutLink() { is_linked_ = false; }
  // From now on the operator's hand is off the device.
  void OpenHand() { is_held_ = false; }
  [[nodiscard]] const core::Pose& X_WC() const { return out_.proxies[0].X_WC; }
  [[nodiscard]] const haptic_node::Outputs& haptic() const { return out_; }
  [[nodiscard]] const core::Reaction& reaction() const { return reactions_[0]; }
  [[nodiscard]] bool is_holding() const {
    return !reactions_.empty() && reactions_[0].grasped_object != core::kNoObject;
  }
  [[nodiscard]] const core::BodyState& body(std::uint16_t object) const;
  // Of the last steps: processor time of the thread, and haptic_node's allocations.
  [[nodiscard]] std::int64_t haptic_cpu_ns() const { return haptic_cpu_ns_; }
  [[nodiscard]] std::int64_t physics_cpu_ns() const { return physics_cpu_ns_; }
  [[nodiscard]] std::uint64_t haptic_allocations() const { return haptic_allocations_; }
  [[nodiscard]] const HandEnergy& energy() const { return energy_; }
  [[nodiscard]] const device_bridge::DeviceBridge& bridge() const { return *bridge_; }
  [[nodiscard]] haptic_node::HapticNode& haptic_node() { return *haptic_; }

 private:
  void Prescribe(std::span<const core::Pose> X_WDs, bool is_engaged);
  void StepBridge();
  void StepHaptic();
  void StepPhysics();
  void TakeHandAlong();

  scene::Scenario scenario_;
  LoopOptions options_;
  core::SerialFor serial_;
  std::unique_ptr<device_bridge::DeviceBridge> bridge_;  // null without a hand
  std::unique_ptr<haptic_node::HapticNode> haptic_;      // null with a closed form
  std::unique_ptr<physics_node::PhysicsNode> physics_;   // null without bodies
  std::int64_t now_ns_ = 0;
  std::uint64_t ticks_ = 0;
  core::FixedVector<core::DeviceState, haptic_node::kMaxRoles> devices_;
  std::deque<core::FixedVector<core::DeviceCommand, haptic_node::kMaxRoles>> commands_;  // on their way to the bridge
  // On its way to physics_node.
  struct Cycle {
    core::FixedVector<core::HapticProxy, haptic_node::kMaxRoles> proxies;
    std::vector<core::ContactSet> contacts;
  };
  std::deque<Cycle> cycles_;
  haptic_node::Outputs out_;
  std::vector<core::ContactSet> contacts_;  // newest of each pair
  physics_node::Outputs physics_out_;
  core::FixedVector<core::Reaction, haptic_node::kMaxRoles> reactions_;
  core::LogicStatus logic_;
  double opening_m_ = 0.0;
  bool is_linked_ = true;
  bool is_held_ = true;
  core::Wrench exerted_before_;     // since the last command
  core::Wrench exerted_at_sample_;  // since the last sample
  HandEnergy energy_;               // of the first device
  std::int64_t haptic_cpu_ns_ = 0;
  std::int64_t physics_cpu_ns_ = 0;
  std::uint64_t haptic_allocations_ = 0;
};

}  // namespace failures
