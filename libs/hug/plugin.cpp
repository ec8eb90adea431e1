#include "hug/plugin.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "device/say_why.hpp"
#include "hug/machine.hpp"

namespace hug {
namespace {

constexpr double kDegree_rad = glm::pi<double>() / 180.0;

// A device's setting with what was wrong in it.
class Options {
 public:
  explicit Options(const oos_device_setting& setting) : setting_(setting) {}
  [[nodiscard]] std::string Text(std::string_view name, std::string_view otherwise = "") const {
    for (std::uint32_t i = 0; i < setting_.num_options; ++i) {
      if (name == setting_.options[i].name) return setting_.options[i].value;
    }
    return std::string(otherwise);
  }
  [[nodiscard]] bool has(std::string_view name) const { return !Text(name).empty(); }
  double Number(std::string_view name, double otherwise) {
    const std::string text = Text(name);
    if (text.empty()) return otherwise;
    double value = otherwise;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      wrong_ += "option " + std::string(name) + ": '" + text + "' is not a number; ";
    }
    return value;
  }
  void Refuse(const std::string& why) { wrong_ += why + "; "; }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }

 private:
  const oos_device_setting& setting_;
  std::string wrong_;
};

struct HugDevice {
  ArmDynamics phantom{LightWeightRobot({})};  // placed where the interpolator wants the arm
  std::shared_ptr<Machine> machine;
  Side side = Side::kRight;
  oos_device_description description{};
  std::uint64_t num_samples = 0;
  std::uint64_t command = 0;
};

// Machines by session, for the second arm to find. Only open() and close() lock it.
std::mutex g_machines_mutex;
std::map<std::string, std::weak_ptr<Machine>>& Machines() {
  static std::map<std::string, std::weak_ptr<Machine>> machines;
  return machines;
}

ControlMode ModeOf(Options* options) {
  const std::string mode = options->Text("control", "impedance");
  if (mode == "gravity") return ControlMode::kGravity;
  if (mode == "admittance") return ControlMode::kAdmittance;
  if (mode == "guidance") return ControlMode::kGuidance;
  if (mode != "impedance") {
    options->Refuse("option control: '" + mode + "' is none of impedance, admittance, gravity, guidance");
  }
  return ControlMode::kImpedance;
}

ArmFigures FiguresOf(Options* options, const std::string& role) {
  ArmFigures f;
  f.control.mode = ModeOf(options);
  f.control.share_of_inertia = options->Number("share_of_inertia", f.control.share_of_inertia);
  if (!(f.control.share_of_inertia > 0.05 && f.control.share_of_inertia <= 1.0)) {
    options->Refuse("option share_of_inertia: write a number above 0.05, at most 1");
    f.control.share_of_inertia = 1.0;
  }
  f.control.body.mass_kg = options->Number("mass_kg", f.control.body.mass_kg);
  f.control.body.inertia_kg_m2 = options->Number("inertia_kg_m2", f.control.body.inertia_kg_m2);
  f.control.body.damping_N_s_per_m = options->Number("damping_N_s_per_m", f.control.body.damping_N_s_per_m);
  f.control.body.damping_Nm_s_per_rad = options->Number("damping_Nm_s_per_rad", f.control.body.damping_Nm_s_per_rad);
  f.hand.stiffness_N_per_m = options->Number("hand_stiffness_N_per_m", f.hand.stiffness_N_per_m);
  f.hand.damping_N_s_per_m = options->Number("hand_damping_N_s_per_m", f.hand.damping_N_s_per_m);
  f.hand.stiffness_Nm_per_rad = options->Number("hand_stiffness_Nm_per_rad", f.hand.stiffness_Nm_per_rad);
  f.hand.damping_Nm_s_per_rad = options->Number("hand_damping_Nm_s_per_rad", f.hand.damping_Nm_s_per_rad);
  f.command_delay_s = options->Number("command_delay_s", 0.0);
  f.opening_max_m = options->Number("opening_max_m", f.opening_max_m);
  f.opening_start_m = options->Number("opening_start_m", f.opening_start_m);
  auto faults = ParseFaults(options->Text("faults"));
  if (faults) {
    f.faults = std::move(*faults);
  } else {
    options->Refuse("option faults: " + faults.error().detail);
  }
  f.seed = 1 + role.size();
  return f;
}

core::Pose StartOf(Options* options) {
  core::Pose X;
  X.rotation = {options->Number("start_qw", 1.0), options->Number("start_qx", 0.0), options->Number("start_qy", 0.0),
                options->Number("start_qz", 0.0)};
  for (int i = 0; i < 3; ++i) {
    constexpr const char* kNames[] = {"start_x_m", "start_y_m", "start_z_m"};
    X.translation[i] = options->Number(kNames[i], 0.0);
  }
  return X;
}

// By hug_x_m, hug_y_m, hug_z_m and hug_yaw_deg; without them such that the ready posture has the hand at its start, the
// operator looking along W's y.
MachineFigures PlaceMachine(Options* options, Side side, const core::Pose& X_WD_start) {
  MachineFigures figures;
  figures.X_WB.rotation =
      core::QuaternionFromRollPitchYaw({0.0, 0.0, options->Number("hug_yaw_deg", 90.0) * kDegree_rad});
  if (options->has("hug_x_m") || options->has("hug_y_m") || options->has("hug_z_m")) {
    figures.X_WB.translation = {options->Number("hug_x_m", 0.0), options->Number("hug_y_m", 0.0),
                                options->Number("hug_z_m", 0.0)};
    return figures;
  }
  Machine there(figures);
  figures.X_WB.translation = X_WD_start.translation - there.arm(side).X_WD().translation;
  return figures;
}

void Describe(const Options& options, const ArmFigures& f, double max_force_N, double max_torque_Nm,
              oos_device_description* d) {
  if (f.control.mode == ControlMode::kGuidance) d->flags |= OOS_DEVICE_LEADS;
  d->flags |= OOS_DEVICE_IS_SIMULATED | OOS_DEVICE_TAKES_HAND | OOS_DEVICE_IS_IMMEDIATE | OOS_DEVICE_TELLS_APPLIED |
              OOS_DEVICE_TELLS_VELOCITY;
  std::strncpy(d->name, "simulated HUG (an arm of two, seven joints)", sizeof d->name - 1);
  std::strncpy(d->serial, options.Text("arm").c_str(), sizeof d->serial - 1);
  d->sensed = d->actuated = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
  d->rate_hz = 3000.0;
  d->max_force_N = max_force_N;
  d->max_torque_Nm = max_torque_Nm;
  d->max_grip_force_N = max_force_N;
  d->mass_kg = f.control.body.mass_kg;
  d->inertia_kg_m2 = f.control.body.inertia_kg_m2;
  d->damping_N_s_per_m = f.control.body.damping_N_s_per_m;
  d->damping_Nm_s_per_rad = f.control.body.damping_Nm_s_per_rad;
  d->reach_m = 0.79;
  d->opening_max_m = f.opening_max_m;
}

std::shared_ptr<Machine> FindMachine(Options* options, Side side, const core::Pose& X_WD_start) {
  const std::string session = options->Text("session");
  const MachineFigures figures = PlaceMachine(options, side, X_WD_start);
  if (session.empty()) return std::make_shared<Machine>(figures);
  std::weak_ptr<Machine>& known = Machines()[session];
  std::shared_ptr<Machine> machine = known.lock();
  if (machine == nullptr) {
    machine = std::make_shared<Machine>(figures);
    known = machine;
  } else if (options->has("hug_x_m") &&
             glm::distance(machine->figures().X_WB.translation, figures.X_WB.translation) > 1e-9) {
    options->Refuse("the other arm of this HUG has it stand elsewhere; give both the same hug_x_m, hug_y_m, hug_z_m");
  }
  return machine;
}

int Open(const oos_device_setting* setting, void** device) {
  Options options(*setting);
  const std::string role = setting->role != nullptr ? setting->role : "";
  const std::string arm = options.Text("arm", role == "left" ? "left" : "right");
  if (arm != "right" && arm != "left") options.Refuse("option arm: write right or left");
  auto made = std::make_unique<HugDevice>();
  made->side = arm == "left" ? Side::kLeft : Side::kRight;
  const ArmFigures figures = FiguresOf(&options, role);
  const core::Pose X_WD_start = StartOf(&options);
  const std::lock_guard lock(g_machines_mutex);
  made->machine = FindMachine(&options, made->side, X_WD_start);
  if (made->machine->is_open(made->side)) {
    options.Refuse("HUG has one " + arm + " arm, and another role has it; write option arm=\"" +
                   (arm == "left" ? "right" : "left") + "\"");
  } else if (!made->machine->Open(made->side, figures, X_WD_start)) {
    const glm::dvec3 there = made->machine->X_WB(made->side).translation;
    options.Refuse("its " + arm + " arm, whose base is at " + std::to_string(there.x) + " " + std::to_string(there.y) +
                   " " + std::to_string(there.z) +
                   ", does not reach the hand's start; move HUG by hug_x_m, hug_y_m and hug_z_m so that the start is "
                   "about 0.6 m in front of that base and 0.2 m above it");
  }
  if (!options.wrong().empty()) {
    device::SayWhy(*setting, options.wrong().substr(0, options.wrong().size() - 2));
    return OOS_DEVICE_BAD_SETTING;
  }
  made->phantom = ArmDynamics(made->machine->arm(made->side).measured().model());
  made->description.size = sizeof made->description;
  Describe(options, figures, options.Number("max_force_N", 40.0), options.Number("max_torque_Nm", 10.0),
           &made->description);
  *device = made.release();
  return OOS_DEVICE_OK;
}

int DescribeDevice(void* device, oos_device_description* description) {
  *description = static_cast<const HugDevice*>(device)->description;
  return OOS_DEVICE_OK;
}

core::Wrench WrenchOf(const double* f) {
  return {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
}
void Put(const glm::dvec3& v, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = v[i];
}

void PutPose(const core::Pose& X, double* out) {
  out[0] = X.rotation.w;
  out[1] = X.rotation.x;
  out[2] = X.rotation.y;
  out[3] = X.rotation.z;
  Put(X.translation, out + 4);
}

Hand HandOf(const oos_device_hand& hand) {
  Hand result;
  result.X_WT = {{hand.X_BT[0], hand.X_BT[1], hand.X_BT[2], hand.X_BT[3]}, {hand.X_BT[4], hand.X_BT[5], hand.X_BT[6]}};
  result.V_WT = {{hand.V_BT[0], hand.V_BT[1], hand.V_BT[2]}, {hand.V_BT[3], hand.V_BT[4], hand.V_BT[5]}};
  result.opening_m = hand.opening_m;
  result.opening_velocity_m_per_s = hand.opening_velocity_m_per_s;
  result.grip_strength_N = hand.grip_strength_N;
  result.holds_dead_man = hand.holds_dead_man != 0;
  return result;
}

void FillState(const Arm& arm, oos_device_state* state) {
  const bool is_engaged = arm.safety().is_engaged() && arm.status().is_clutch_closed;
  state->flags = is_engaged ? OOS_DEVICE_IS_ENGAGED : OOS_DEVICE_IS_OFF;
  PutPose(arm.X_WD(), state->X_BD);
  const core::Twist V = arm.V_WD();
  Put(V.angular_rad_per_s, state->V_BD);
  Put(V.linear_m_per_s, state->V_BD + 3);
  state->opening_m = arm.gripper().opening_m;
  state->opening_velocity_m_per_s = arm.gripper().velocity_m_per_s;
  const core::Wrench motors = arm.motors_F_Do_W();
  Put(motors.force_N, state->applied);
  Put(motors.torque_Nm, state->applied + 3);
  state->applied[6] = arm.motor_grip_N();
  Put(arm.hand_F_Do_W().force_N, state->hand_F_Do_B);
  Put(arm.hand_F_Do_W().torque_Nm, state->hand_F_Do_B + 3);
  state->finger_force_N = arm.gripper().finger_N;
}

int Step(void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
         oos_device_state* state) {
  auto& self = *static_cast<HugDevice*>(device);
  self.machine->AdvanceTo(now_ns);
  Arm& arm = self.machine->arm(self.side);
  if (arm.is_unplugged()) return OOS_DEVICE_GONE;
  if (command != nullptr) {
    self.command = command->sequence;
    arm.Send({WrenchOf(command->F_Do_B), command->grip_force_N, command->brake_N_s_per_m, command->brake_Nm_s_per_rad});
  }
  if (hand != nullptr) arm.SetHand(HandOf(*hand));
  state->sequence = ++self.num_samples;
  state->reflected = self.command;
  state->device_time_ns = now_ns;
  FillState(arm, state);
  return OOS_DEVICE_OK;
}

int FillJoints(void* device, oos_device_joints* joints) {
  auto& self = *static_cast<HugDevice*>(device);
  const Arm& arm = self.machine->arm(self.side);
  const ArmStatus& status = arm.status();
  *joints = {};
  joints->size = sizeof *joints;
  joints->num_joints = kJoints;
  joints->state = static_cast<std::uint32_t>(status.state);
  joints->first_cause = static_cast<std::uint32_t>(status.first_cause);
  joints->has_target = status.target ? 1 : 0;
  if (status.target) self.phantom.Place(self.machine->X_WB(self.side), *status.target, {});
  PutPose(status.target ? self.phantom.X_WD() : core::Pose{}, joints->X_BD_target);
  for (std::size_t i = 0; i < kJoints; ++i) {
    oos_device_joint& joint = joints->joints[i];
    PutPose(arm.measured().X_WL(i), joint.X_BL);
    PutPose(status.target ? self.phantom.X_WL(i) : core::Pose{}, joint.X_BL_target);
    joint.position_rad = status.position[i];
    joint.speed_rad_per_s = status.speed[i];
    joint.measured_Nm = status.measured_Nm[i];
    joint.commanded_Nm = status.commanded_Nm[i];
    joint.temperature_degC = status.temperature_degC[i];
    joint.radius_m = RadiusOf(i);
  }
  return OOS_DEVICE_OK;
}

int Lead(void* device, const oos_device_goal* goal) {
  auto& self = *static_cast<HugDevice*>(device);
  Arm& arm = self.machine->arm(self.side);
  if (goal == nullptr) {
    arm.StopLeading();
    return OOS_DEVICE_OK;
  }
  const double* X = goal->X_BG;
  arm.Lead({{{X[0], X[1], X[2], X[3]}, {X[4], X[5], X[6]}}, goal->max_force_N, goal->max_torque_Nm});
  return OOS_DEVICE_OK;
}

void Close(void* device) {
  auto* self = static_cast<HugDevice*>(device);
  const std::lock_guard lock(g_machines_mutex);
  self->machine->Close(self->side);
  delete self;
}

}  // namespace

const oos_device_plugin& Plugin() {
  static const oos_device_plugin plugin{
      OOS_DEVICE_ABI_VERSION, sizeof plugin, Open, DescribeDevice, Step, Close, nullptr, FillJoints, Lead};
  return plugin;
}

}  // namespace hug
