#include "nodes/device_bridge/arms/arm_plugin.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

#include "nodes/device_bridge/arms/simulated_arm.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {
namespace {

struct NamedFigure {
  const char* name;
  double scene::Device::*figure;
};
constexpr NamedFigure kFigures[] = {
    {"mass_kg", &scene::Device::mass_kg},
    {"inertia_kg_m2", &scene::Device::inertia_kg_m2},
    {"damping_N_s_per_m", &scene::Device::damping_N_s_per_m},
    {"damping_Nm_s_per_rad", &scene::Device::damping_Nm_s_per_rad},
    {"opening_max_m", &scene::Device::opening_max_m},
    {"opening_start_m", &scene::Device::opening_start_m},
    {"command_delay_s", &scene::Device::command_delay_s},
    {"hand_stiffness_N_per_m", &scene::Device::hand_stiffness_N_per_m},
    {"hand_damping_N_s_per_m", &scene::Device::hand_damping_N_s_per_m},
    {"hand_stiffness_Nm_per_rad", &scene::Device::hand_stiffness_Nm_per_rad},
    {"hand_damping_Nm_s_per_rad", &scene::Device::hand_damping_Nm_s_per_rad},
    {"max_force_N", &scene::Device::max_force_N},
    {"max_torque_Nm", &scene::Device::max_torque_Nm},
};
constexpr const char* kStartNames[7] = {"start_qw",  "start_qx",  "start_qy", "start_qz",
                                        "start_x_m", "start_y_m", "start_z_m"};

std::string TextOf(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

double ValueOf(const oos_device_setting& setting, std::string_view name, double otherwise) {
  for (std::uint32_t i = 0; i < setting.num_options; ++i) {
    if (name != setting.options[i].name) continue;
    const std::string_view text = setting.options[i].value;
    double value = otherwise;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }
  return otherwise;
}

struct ArmDevice {
  ArmParameters parameters;
  SimulatedArm arm;
  scene::Device figures;
  std::uint64_t num_samples = 0;
  std::uint64_t command = 0;  // newest

  explicit ArmDevice(const scene::Device& device)
      : parameters(ArmParameters::From(device)), arm(parameters), figures(device) {}
};

int Open(const oos_device_setting& setting, const char* type, void** device) {
  scene::Device figures = ArmFiguresOf(setting);
  figures.type = type;
  *device = new ArmDevice(figures);
  return OOS_DEVICE_OK;
}

int OpenArm(const oos_device_setting* setting, void** device) {
  return Open(*setting, "simulated_arm", device);
}
int OpenHug(const oos_device_setting* setting, void** device) {
  return Open(*setting, "simulated_hug", device);
}

int DescribeArm(void* device, oos_device_description* d) {
  const auto& arm = *static_cast<const ArmDevice*>(device);
  d->flags = OOS_DEVICE_IS_SIMULATED | OOS_DEVICE_TAKES_HAND | OOS_DEVICE_IS_IMMEDIATE | OOS_DEVICE_TELLS_APPLIED |
             OOS_DEVICE_TELLS_VELOCITY;
  const std::string_view name = arm.parameters.is_jointed ? "simulated arm (seven joints, gripper axis)"
                                                          : "simulated arm (6-DoF mass-damper, gripper axis)";
  name.copy(d->name, sizeof d->name - 1);
  d->sensed = d->actuated = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
  d->rate_hz = 1000.0;
  d->max_force_N = arm.figures.max_force_N;
  d->max_torque_Nm = arm.figures.max_torque_Nm;
  d->max_grip_force_N = arm.figures.max_force_N;
  d->mass_kg = arm.figures.mass_kg;
  d->inertia_kg_m2 = arm.figures.inertia_kg_m2;
  d->damping_N_s_per_m = arm.figures.damping_N_s_per_m;
  d->damping_Nm_s_per_rad = arm.figures.damping_Nm_s_per_rad;
  d->opening_max_m = arm.figures.opening_max_m;
  return OOS_DEVICE_OK;
}

HandTarget TargetOf(const oos_device_hand& hand) {
  HandTarget target;
  target.X_WT = PoseOf(hand.X_BT);
  target.V_WT = TwistOf(hand.V_BT);
  target.opening_m = hand.opening_m;
  target.opening_velocity_m_per_s = hand.opening_velocity_m_per_s;
  target.grip_strength_N = hand.grip_strength_N;
  target.holds_dead_man = hand.holds_dead_man != 0;
  return target;
}

int StepArm(void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
            oos_device_state* state) {
  auto& self = *static_cast<ArmDevice*>(device);
  const DeviceReading reading = self.arm.Read(now_ns);
  if (command != nullptr) {
    self.command = command->sequence;
    self.arm.Write(now_ns, {WrenchOf(command->F_Do_B), command->grip_force_N, command->brake_N_s_per_m,
                            command->brake_Nm_s_per_rad});
  }
  if (hand != nullptr) self.arm.SetHand(TargetOf(*hand));
  state->flags = reading.is_engaged ? OOS_DEVICE_IS_ENGAGED : 0;
  state->sequence = ++self.num_samples;
  state->reflected = self.command;
  state->device_time_ns = now_ns;
  ToArray(reading.X_WD, state->X_BD);
  ToArray(reading.V_WD, state->V_BD);
  state->opening_m = reading.opening_m;
  state->opening_velocity_m_per_s = reading.opening_velocity_m_per_s;
  const FeltForce felt = self.arm.Felt();
  ToArray(felt.F_Do_W, state->applied);
  state->applied[6] = felt.grip_force_N;
  ToArray(felt.hand_F_Do_W, state->hand_F_Do_B);
  state->finger_force_N = felt.finger_force_N;
  return OOS_DEVICE_OK;
}

void CloseArm(void* device) {
  delete static_cast<ArmDevice*>(device);
}

}  // namespace

const oos_device_plugin& SimulatedArmPlugin() {
  static const oos_device_plugin plugin{
      OOS_DEVICE_ABI_VERSION, sizeof plugin, OpenArm, DescribeArm, StepArm, CloseArm, nullptr, nullptr, nullptr};
  return plugin;
}

const oos_device_plugin& SimulatedHugPlugin() {
  static const oos_device_plugin plugin{
      OOS_DEVICE_ABI_VERSION, sizeof plugin, OpenHug, DescribeArm, StepArm, CloseArm, nullptr, nullptr, nullptr};
  return plugin;
}

scene::Device ArmFiguresOf(const oos_device_setting& setting) {
  scene::Device figures;
  for (const NamedFigure& known : kFigures) {
    figures.*known.figure = ValueOf(setting, known.name, figures.*known.figure);
  }
  double start[7];
  ToArray(figures.X_WD_start, start);
  for (int i = 0; i < 7; ++i) start[i] = ValueOf(setting, kStartNames[i], start[i]);
  figures.X_WD_start = PoseOf(start);
  return figures;
}

std::vector<std::pair<std::string, std::string>> ArmOptions(const scene::Device& device) {
  std::vector<std::pair<std::string, std::string>> options;
  for (const NamedFigure& known : kFigures) options.emplace_back(known.name, TextOf(device.*known.figure));
  double start[7];
  ToArray(device.X_WD_start, start);
  for (int i = 0; i < 7; ++i) options.emplace_back(kStartNames[i], TextOf(start[i]));
  return options;
}

}  // namespace device_bridge
