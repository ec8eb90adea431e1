#include "nodes/device_bridge/device_bridge.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

#include "core/clock.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {
namespace {

constexpr std::uint64_t kAllowedPeriod_ticks = 64;  // 16/s: the delay's average moves slower

}  // namespace

core::Result<std::unique_ptr<DeviceBridge>> DeviceBridge::Create(const scene::Scenario& scenario, std::uint64_t seed,
                                                                 const Options& options) {
  if (scenario.devices.size() > kMaxRoles) {
    return core::Fail(core::ErrorCode::kUnsupported,
                      "scenario '" + scenario.name + "' has " + std::to_string(scenario.devices.size()) +
                          " devices; at most " + std::to_string(kMaxRoles) + " can be bridged by one node");
  }
  core::Result<OperatorScript> script = LoadOperatorScript(scenario);
  if (!script) return tl::unexpected(script.error());

  std::size_t num_samples = options.num_echoes;
  if (num_samples == 0) {
    const double seconds = std::clamp(scenario.duration_limit_s + 10.0, 10.0, 3600.0);
    num_samples = static_cast<std::size_t>(seconds * 1000.0) * std::max<std::size_t>(1, scenario.devices.size());
  }
  std::unique_ptr<DeviceBridge> bridge(new DeviceBridge(scenario, options, num_samples));
  // Roles whose devices are parts of one machine find each other by it.
  static std::atomic<std::uint64_t> num_bridges{0};
  const std::string session = std::to_string(++num_bridges);
  for (const scene::Device& device : bridge->scenario_.devices) {
    scene::Device with_session = device;
    with_session.options.emplace_back("session", session);
    auto made = MakeDevice(with_session, options.threads);
    if (!made) return tl::unexpected(made.error());
    const core::Result<SafetyFilter> filter = SafetyFilter::Create(FilterLimits::From(device, scenario.force_cap_N));
    if (!filter) {
      return core::Fail(filter.error().code, "device '" + device.role + "': " + filter.error().detail);
    }
    auto role = std::make_unique<Role>(*filter, device, scenario.coupling);
    role->device = std::move(*made);
    auto muscle = MuscleGrip::Create(device, seed + bridge->roles_.size());
    if (!muscle) return tl::unexpected(muscle.error());
    role->muscle = std::move(*muscle);
    bridge->has_hands_ = bridge->has_hands_ || role->device->takes_hand();
    bridge->roles_.push_back(std::move(role));
  }
  auto weight = ReleasedWeight::Create(bridge->scenario_);
  if (!weight) return tl::unexpected(weight.error());
  bridge->released_weight_ = std::move(*weight);
  if (options.is_person_steering) bridge->pointer_.emplace(bridge->scenario_);
  bridge->operator_ =
      std::make_unique<SimulatedOperator>(bridge->scenario_, std::move(*script), seed, options.operator_options);
  if (options.is_person_steering) bridge->guide_.emplace(bridge->scenario_, bridge->operator_->script());
  return bridge;
}

void DeviceBridge::TakeDescription(std::size_t role_index) noexcept {
  Role& role = *roles_[role_index];
  if (role.device->takes_hand() || role.device->num_found() == role.num_found) return;
  role.num_found = role.device->num_found();
  const oos_device_description& d = role.device->description();
  const auto or_else = [](double given, double otherwise) {
    return std::isfinite(given) && given > 0.0 ? given : otherwise;
  };
  FilterLimits limits = role.filter.limits();
  limits.max_force_N = or_else(d.max_force_N, limits.max_force_N);
  limits.max_torque_Nm = or_else(d.max_torque_Nm, limits.max_torque_Nm);
  limits.max_grip_force_N = or_else(d.max_grip_force_N, limits.max_grip_force_N);
  role.filter.Tighten(limits);
  scene::Device& device = scenario_.devices[role_index];
  device.mass_kg = or_else(d.mass_kg, device.mass_kg);
  device.inertia_kg_m2 = or_else(d.inertia_kg_m2, device.inertia_kg_m2);
  device.damping_N_s_per_m = or_else(d.damping_N_s_per_m, device.damping_N_s_per_m);
  device.damping_Nm_s_per_rad = or_else(d.damping_Nm_s_per_rad, device.damping_Nm_s_per_rad);
  role.passivity = Passivity({device.mass_kg, device.inertia_kg_m2, scenario_.coupling.stiffness_N_per_m,
                              scenario_.coupling.stiffness_Nm_per_rad});
}

void DeviceBridge::Write(Role* role, std::int64_t now_ns, const core::DeviceCommand* accepted) noexcept {
  role->reading = role->device->Read(now_ns);
  if (accepted != nullptr) role->field.Take(*accepted, role->reading.X_WD, now_ns);
  double others_J = released_weight_.energy_J();
  for (const auto& other : roles_) others_J += other.get() == role ? 0.0 : other->passivity.energy_J();
  const bool is_in_full = (role->filter.status() & kForceNotInFull) == 0;
  // What no motor makes is not felt, and is no energy.
  const std::uint32_t motors = role->device->description().actuated;
  const core::Wrench acted = OfMotors(motors, role->written.F_Do_W());
  core::Wrench added =
      OfMotors(motors, role->passivity.Step(role->reading, acted, is_in_full, motors == 0 ? 0.0 : others_J));
  if (!options_.is_made_passive) added = {};
  core::Wrench rest;
  if (role->field.is_active()) added += role->field.Change(role->reading.X_WD, now_ns, &rest);
  role->written = role->filter.Apply(now_ns, role->reading, added);
  role->device->Write(now_ns, role->written);
  role->impulse.Add(now_ns, role->field.is_active() ? role->written.F_Do_W() : core::Wrench{},
                    role->field.F_Do_W() + added, rest, role->reading.X_WD.translation);
  if ((role->filter.status() & kSilent) != 0) role->field.Forget();

  RoleFigures& figures = role->figures;
  const core::Wrench felt = OfMotors(motors, role->written.F_Do_W());
  const double force_N = glm::length(felt.force_N);
  ++figures.writes;
  figures.peak_force_N = std::max(figures.peak_force_N, force_N);
  figures.peak_torque_Nm = std::max(figures.peak_torque_Nm, glm::length(felt.torque_Nm));
  figures.peak_grip_force_N = std::max(figures.peak_grip_force_N, std::abs(role->written.grip_force_N()));
  if (force_N > role->filter.limits().max_force_N) ++figures.samples_over_limit;
  if (force_N > 0.1) ++figures.samples_in_force;
  if (force_N > 0.0) {
    figures.oldest_force_ms = std::max(figures.oldest_force_ms, static_cast<double>(now_ns - role->accepted_ns) * 1e-6);
  }
  const std::uint32_t status = role->filter.status();
  for (unsigned bit = 0; bit < 32; ++bit) figures.status_samples[bit] += (status >> bit) & 1U;
  const bool is_silent = (status & (kSilent | kNoCommand)) != 0;
  if (is_silent && !role->was_silent) ++figures.link_losses;
  role->was_silent = is_silent;
}

void DeviceBridge::AcceptCommand(std::size_t role_index, const core::DeviceCommand& command, std::int64_t received_ns,
                                 std::int64_t now_ns) noexcept {
  if (role_index >= roles_.size() || command.header.sequence == 0) return;
  Role& role = *roles_[role_index];
  if (command.header.sequence == role.passed_sequence && received_ns == role.passed_received_ns) return;
  role.passed_sequence = command.header.sequence;
  role.passed_received_ns = received_ns;
  role.filter.Accept(command, received_ns, physics_alive_ns_);
  const bool is_accepted = role.filter.was_accepted();
  if (is_accepted) role.accepted_ns = received_ns;
  Write(&role, now_ns, is_accepted ? &command : nullptr);
  if (!is_accepted) return;
  const std::int64_t written_ns = Now(now_ns);
  core::Header header = command.header;
  for (core::Trace* trace : {&header.direct, &header.through_physics}) {
    trace->Add(core::Stage::kDeviceReceive, received_ns);
    trace->Add(core::Stage::kDeviceWrite, written_ns);
  }
  // Reads the clock itself: the log must not depend on the stamps.
  const std::optional<std::int64_t> delay_ns = echo_log_.RecordWrite(header, Now(now_ns));
  if (delay_ns) role.loop_delay.Add(*delay_ns);
}

void DeviceBridge::UpdateAllowedCoupling(std::size_t role_index) noexcept {
  Role& role = *roles_[role_index];
  // The roles take turns, so that no tick has the work of two.
  if (!role.loop_delay.is_measured() || ticks_ % kAllowedPeriod_ticks != role_index) return;
  const scene::Device& device = scenario_.devices[role_index];
  const double delay_s = role.field.is_active() ? device.command_delay_s : role.loop_delay.late_s();
  role.allowed = ComputeAllowedCoupling(device, scenario_.coupling, role.field.p_CoCm_C(), delay_s);
  role.stiffness_share = role.allowed.share;
  if (role.least_stiffness_share == 0.0 || role.stiffness_share < role.least_stiffness_share) {
    role.least_stiffness_share = role.stiffness_share;
  }
}

// Every hand's device can. One that is plugged in may be another than before.
bool DeviceBridge::CanLead() const noexcept {
  return std::all_of(roles_.begin(), roles_.end(), [](const auto& role) { return role->device->can_lead(); });
}

// Where the person is told to go, and there it is held while the jaws are to move. Not where the filter withholds
// force.
void DeviceBridge::LeadHands(bool can_lead) noexcept {
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    Role& role = *roles_[i];
    const Tip& tip = guide_->tip(i);
    const bool may_lead = can_lead && pointer_->wants_guidance() && tip.kind != core::GuideKind::kNone &&
                          (role.filter.status() & kForceNotInFull) == 0;
    if (tip.kind == core::GuideKind::kMove) role.goal.X_WG = tip.X_WG;
    role.is_led = may_lead && (role.is_led || tip.kind == core::GuideKind::kMove);
    role.goal.max_force_N = role.filter.limits().max_force_N;
    role.goal.max_torque_Nm = role.filter.limits().max_torque_Nm;
    role.device->Lead(role.is_led ? &role.goal : nullptr);
    pointer_->SetLed(i, role.is_led);
  }
}

// While a person asks for guidance, devices that can lead the hands do. With others the scripted operator shows how the
// step is done, from where the hands are.
void DeviceBridge::StepOperator(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                                const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept {
  if (!pointer_) {
    operator_->Step(inputs, felt, readings);
    return;
  }
  guide_->Step(inputs, felt, readings);
  const bool can_lead = CanLead();
  LeadHands(can_lead);
  pointer_->Step(inputs, felt, readings, core::kTick_s);
  const bool is_guided = pointer_->wants_guidance() && !can_lead && has_hands_;
  const bool changes = is_guided != is_guided_;
  is_guided_ = is_guided;
  if (changes && is_guided_) {
    for (std::size_t i = 0; i < roles_.size(); ++i) operator_->TakeUp(i, pointer_->target(i));
  }
  if (is_guided_) {
    operator_->Step(inputs, felt, readings);
    for (std::size_t i = 0; i < roles_.size(); ++i) pointer_->TakeUp(i, operator_->target(i));
  } else {
    operator_->Watch(inputs, felt, readings);
  }
}

HandTarget DeviceBridge::Target(std::size_t role_index) noexcept {
  HandTarget target = pointer_ && !is_guided_ ? pointer_->target(role_index) : operator_->target(role_index);
  if (auto& muscle = roles_[role_index]->muscle) target.grip_strength_N = muscle->Step(target.grip_strength_N);
  return target;
}

void DeviceBridge::Step(const Inputs& inputs, Outputs* outputs) noexcept {
  ++ticks_;
  outputs->states.clear();
  outputs->applied.clear();
  outputs->filter_status.clear();
  if (inputs.physics != nullptr && inputs.physics->header.sequence != physics_sequence_) {
    physics_sequence_ = inputs.physics->header.sequence;
    physics_alive_ns_ = inputs.now_ns;
    released_weight_.Update(*inputs.physics);
  }

  core::FixedVector<FeltForce, kMaxRoles> felt;
  core::FixedVector<DeviceReading, kMaxRoles> readings;
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    Role& role = *roles_[i];
    if (i < inputs.commands.size()) {
      const std::int64_t received_ns =
          i < inputs.command_received_ns.size() ? inputs.command_received_ns[i] : inputs.now_ns;
      AcceptCommand(i, inputs.commands[i], received_ns, inputs.now_ns);
    }
    Write(&role, inputs.now_ns);
    role.health = role.device->Health(inputs.now_ns);
    role.presence.Step(role.health, role.reading.sample_ns);
    TakeDescription(i);
    UpdateAllowedCoupling(i);
    felt.push_back(role.device->Felt());
    felt[i].is_off = (role.filter.status() & kSilent) != 0 || role.filter.is_restarting() ||
                     (role.device->state().flags & OOS_DEVICE_IS_OFF) != 0;
    readings.push_back(role.reading);
  }
  if (has_hands_ || pointer_) StepOperator(inputs, felt, readings);
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    Role& role = *roles_[i];
    if (role.device->takes_hand()) role.device->SetHand(Target(i));

    core::DeviceState state;
    state.header.sequence = ++role.sample_sequence;
    state.header.publish_ns = inputs.now_ns;
    state.header.direct.id = core::MakeTraceId(static_cast<unsigned>(i), role.sample_sequence);
    state.header.direct.origin_ns = inputs.now_ns;
    state.header.direct.Add(core::Stage::kDeviceSample, inputs.now_ns);
    state.role_index = static_cast<std::uint8_t>(i);
    state.sample_ns = role.reading.sample_ns != 0 ? role.reading.sample_ns : inputs.now_ns;
    state.X_WD = role.reading.X_WD;
    state.V_WD = role.reading.V_WD;
    state.opening_m = role.reading.opening_m;
    state.opening_velocity_m_per_s = role.reading.opening_velocity_m_per_s;
    state.finger_rad = role.reading.finger_rad;
    state.is_engaged = role.reading.is_engaged;
    state.is_simulated = role.device->is_simulated();
    state.J_contact_Wo_W = role.impulse.J_Wo_W();
    outputs->states.push_back(state);
    outputs->applied.push_back(role.written.F_Do_W());
    outputs->filter_status.push_back(role.filter.status());
    echo_log_.RecordSample(static_cast<unsigned>(i), role.sample_sequence, inputs.now_ns);
  }
}

bool DeviceBridge::Joints(std::size_t role_index, core::DeviceJoints* joints) const noexcept {
  if (role_index >= roles_.size()) return false;
  const Role& role = *roles_[role_index];
  oos_device_joints there{};
  if (!role.device->Joints(&there)) return false;
  joints->role_index = static_cast<std::uint8_t>(role_index);
  joints->is_simulated = role.device->is_simulated();
  joints->state = static_cast<std::uint8_t>(there.state);
  joints->first_cause = static_cast<std::uint8_t>(there.first_cause);
  joints->has_target = there.has_target != 0;
  const core::Pose X_WB = role.device->X_WB();
  joints->X_WD = X_WB * PoseOf(role.device->state().X_BD);
  joints->X_WD_target = X_WB * PoseOf(there.X_BD_target);
  joints->joints.clear();
  for (std::uint32_t i = 0; i < there.num_joints; ++i) {
    const oos_device_joint& from = there.joints[i];
    core::DeviceJoint joint;
    joint.X_WL = X_WB * PoseOf(from.X_BL);
    joint.X_WL_target = X_WB * PoseOf(from.X_BL_target);
    joint.position_rad = static_cast<float>(from.position_rad);
    joint.speed_rad_per_s = static_cast<float>(from.speed_rad_per_s);
    joint.measured_Nm = static_cast<float>(from.measured_Nm);
    joint.commanded_Nm = static_cast<float>(from.commanded_Nm);
    joint.temperature_degC = static_cast<float>(from.temperature_degC);
    joint.radius_m = static_cast<float>(from.radius_m);
    joints->joints.push_back(joint);
  }
  return true;
}

RoleFigures DeviceBridge::figures(std::size_t role) const {
  RoleFigures figures = roles_[role]->figures;
  figures.commands_accepted = roles_[role]->filter.num_accepted();
  figures.commands_refused = roles_[role]->filter.num_refused();
  const Role& r = *roles_[role];
  figures.loop_delay_s = r.loop_delay.mean_s();
  figures.loop_jitter_s = r.loop_delay.jitter_s();
  figures.allowed = r.allowed;
  figures.stiffness_share = r.stiffness_share;
  figures.least_stiffness_share = r.least_stiffness_share;
  figures.energy_J = r.passivity.energy_J();
  figures.least_energy_J = r.passivity.least_energy_J();
  figures.samples_made_passive = r.passivity.num_acting();
  figures.first_cause = roles_[role]->filter.first_cause();
  figures.first_cause_ns = roles_[role]->filter.first_cause_ns();
  return figures;
}

}  // namespace device_bridge
