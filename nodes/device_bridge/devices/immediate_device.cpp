#include "nodes/device_bridge/devices/immediate_device.hpp"

#include <cstddef>

#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {

core::Result<std::unique_ptr<ImmediateDevice>> ImmediateDevice::Create(PluginTable plugin,
                                                                       const scene::Device& device) {
  std::unique_ptr<ImmediateDevice> made(new ImmediateDevice(std::move(plugin)));
  const oos_device_plugin& functions = *made->plugin_.functions;
  const DeviceSetting setting(device);
  auto& why = made->health_.why;
  const oos_device_setting view = setting.View(why.data(), static_cast<std::uint32_t>(why.size()));
  made->description_.size = sizeof made->description_;
  if (functions.open(&view, &made->device_) != OOS_DEVICE_OK ||
      functions.describe(made->device_, &made->description_) != OOS_DEVICE_OK) {
    return core::Fail(core::ErrorCode::kInvalidInput, why.data());
  }
  made->health_.status = DeviceStatus::kAlive;
  made->health_.quality = LinkQuality::kExcellent;
  made->health_.link.rate_hz = made->description_.rate_hz;
  return made;
}

ImmediateDevice::~ImmediateDevice() {
  if (device_ != nullptr) plugin_.functions->close(device_);
}

void ImmediateDevice::Step(std::int64_t now_ns, const oos_device_command* command,
                           const oos_device_hand* hand) noexcept {
  last_ns_ = now_ns;
  if (plugin_.functions->step(device_, now_ns, command, hand, &state_) == OOS_DEVICE_OK) {
    health_.status = DeviceStatus::kAlive;
    return;
  }
  // A simulated device that was unplugged stays where it was, let go.
  health_.status = DeviceStatus::kGone;
  ++health_.num_misses;
  state_.flags = OOS_DEVICE_IS_OFF;
  for (double& v : state_.V_BD) v = 0.0;
  for (double& f : state_.applied) f = 0.0;
  state_.opening_velocity_m_per_s = 0.0;
}

bool ImmediateDevice::Joints(oos_device_joints* joints) noexcept {
  if (!GivesJoints(plugin_)) return false;
  joints->size = sizeof *joints;
  return plugin_.functions->joints(device_, joints) == OOS_DEVICE_OK && joints->num_joints <= OOS_DEVICE_MAX_JOINTS;
}

DeviceReading ImmediateDevice::Read(std::int64_t now_ns) noexcept {
  Step(now_ns, nullptr, nullptr);
  DeviceReading reading;
  reading.X_WD = PoseOf(state_.X_BD);
  reading.V_WD = TwistOf(state_.V_BD);
  reading.opening_m = state_.opening_m;
  reading.opening_velocity_m_per_s = state_.opening_velocity_m_per_s;
  reading.finger_rad = FingersOf(state_);
  reading.is_engaged = (state_.flags & OOS_DEVICE_IS_ENGAGED) != 0;
  return reading;
}

void ImmediateDevice::Write(std::int64_t now_ns, const FilteredForce& force) noexcept {
  oos_device_command command{};
  command.size = sizeof command;
  command.sequence = ++num_commands_;
  ToArray(OfMotors(description_.actuated, force.F_Do_W()), command.F_Do_B);
  command.grip_force_N = force.grip_force_N();
  command.brake_N_s_per_m = force.brake_N_s_per_m();
  command.brake_Nm_s_per_rad = force.brake_Nm_s_per_rad();
  if (!is_muted_) Step(now_ns, &command, nullptr);
}

void ImmediateDevice::SetHand(const HandTarget& target) noexcept {
  oos_device_hand hand{};
  hand.size = sizeof hand;
  hand.holds_dead_man = target.holds_dead_man ? 1 : 0;
  ToArray(target.X_WT, hand.X_BT);
  ToArray(target.V_WT, hand.V_BT);
  hand.opening_m = target.opening_m;
  hand.opening_velocity_m_per_s = target.opening_velocity_m_per_s;
  hand.grip_strength_N = target.grip_strength_N;
  Step(last_ns_, nullptr, &hand);
}

void ImmediateDevice::Lead(const LeadGoal* goal) noexcept {
  if (!can_lead()) return;
  oos_device_goal there{};
  const bool is_usable = goal != nullptr && FillGoal(goal->X_WG, goal->max_force_N, goal->max_torque_Nm, &there);
  plugin_.functions->lead(device_, is_usable ? &there : nullptr);
}

FeltForce ImmediateDevice::Felt() const noexcept {
  FeltForce felt;
  felt.F_Do_W = WrenchOf(state_.applied);
  felt.grip_force_N = state_.applied[6];
  felt.hand_F_Do_W = WrenchOf(state_.hand_F_Do_B);
  felt.finger_force_N = state_.finger_force_N;
  felt.opening_m = state_.opening_m;
  return felt;
}

}  // namespace device_bridge
