#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/parallel_for.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/scenario.hpp"

namespace failures {

struct LoopOptions {
  std::string script;  // of the simulated operator, without its step line
  double tremor_m = 0.0;
  std::uint64_t seed = 1;
  int command_delay_ticks = 0;      // from haptic_node to the bridge
  int contact_delay_ticks = 0;      // from haptic_node to physics_node
  std::uint64_t budget_points = 0;  // of haptic_node's collision; 0: no limit
  // In place of haptic_node: the force on the hand in closed form.
  std::function<core::Wrench(const core::DeviceState&)> answer;
};

// The steps of device_bridge, haptic_node and, if the scene has bodies, physics_node, in turn on a virtual clock of
// 1 ms. A command is in the arm in the same tick as the sample that it was made from, as on one fast machine, unless
// it is delayed; poses of bodies arrive one tick later.
class Loop {
 public:
  explicit Loop(const scene::Scenario& scenario, const LoopOptions& options = {});

  // One tick: the bridge moves the hand as the operator's script says.
  void Tick();
  // One tick in place of the bridge: the device is at this pose.
  void Tick(const core::Pose& X_WD) { Prescribe(X_WD, true); }
  // The same, with the dead-man switch released: the tool is put where the device is.
  void LetGo(const core::Pose& X_WD) { Prescribe(X_WD, false); }
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
  [[nodiscard]] const core::BodyState& body(std::uint16_t object) const;
  // Energy that the hand has put into the scene through the arm's force, exact: forces are constant within a tick.
  [[nodiscard]] double energy_J() const { return energy_J_; }
  [[nodiscard]] double least_energy_J() const { return least_energy_J_; }
  [[nodiscard]] const device_bridge::DeviceBridge& bridge() const { return *bridge_; }
  [[nodiscard]] haptic_node::HapticNode& haptic_node() { return *haptic_; }

 private:
  void Prescribe(const core::Pose& X_WD, bool is_engaged);
  void StepBridge();
  void StepHaptic();
  void StepPhysics();
  void CountEnergy();
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
  std::deque<core::DeviceCommand> commands_;                // on their way to the bridge
  std::deque<std::vector<core::ContactSet>> contact_sets_;  // on their way to physics_node
  haptic_node::Outputs out_;
  std::vector<core::ContactSet> contacts_;  // newest of each pair
  physics_node::Outputs physics_out_;
  core::FixedVector<core::Reaction, haptic_node::kMaxRoles> reactions_;
  core::LogicStatus logic_;
  bool is_linked_ = true;
  bool is_held_ = true;
  core::Wrench exerted_before_;
  core::Pose X_WD_before_;
  double energy_J_ = 0.0;
  double least_energy_J_ = 0.0;
};

}  // namespace failures
