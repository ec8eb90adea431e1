#include "nodes/device_bridge/node_loop.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bus/membership/clock_bounds.hpp"
#include "bus/rt/periodic_loop.hpp"
#include "core/clock.hpp"
#include "core/hand_guide.hpp"
#include "core/hand_limits.hpp"
#include "core/messages/reserve_texts.hpp"
#include "nodes/device_bridge/report.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kFiguresPeriod_ns = 500'000'000;  // fast enough for a display that people read
constexpr std::int64_t kTipsPeriod_ns = 66'000'000;      // while a person steers by them
constexpr std::uint64_t kTicksPerHead = 8;               // 125/s: more than displays show
constexpr std::uint64_t kTicksPerJoints = 16;            // for people to watch
constexpr std::int64_t kMiss_ns = core::kTick_ns / 2;    // a later sample is closer to the next tick

std::size_t NumForceSamples(const scene::Scenario& scenario) {
  const double seconds = std::clamp(scenario.duration_limit_s + 10.0, 10.0, 3600.0);
  return static_cast<std::size_t>(seconds / core::kTick_s) * scenario.devices.size();
}

// From the loss or the return of a device to its notice.
std::string StepsSince(const Presence& presence, bool is_found) {
  if (presence.num_losses() == 0) return "";
  return is_found ? ", in step " + std::to_string(presence.steps_to_found()) + " after it was away"
                  : ", in step " + std::to_string(presence.steps_to_lost()) + " after its last sample";
}

}  // namespace

NodeLoop::NodeLoop(const scene::Scenario& scenario, std::vector<std::unique_ptr<HeadTracker>> heads,
                   std::unique_ptr<Tactiles> tactiles, DeviceBridge* bridge, bus::Node* node,
                   std::vector<std::string> viewers)
    : scenario_(scenario),
      bridge_(bridge),
      node_(node),
      viewers_(std::move(viewers)),
      tactiles_(std::move(tactiles)),
      reported_status_(scenario.devices.size(), kNoCommand),
      silent_event_{0, "device_bridge", "force_faded", "no command for 60 ms: the device force is zero"},
      back_event_{0, "device_bridge", "force_back", "commands arrive again"},
      fault_event_{0, "device_bridge", "filter_fault",
                   "a command was not finite: no force until the dead-man is released"},
      force_log_(NumForceSamples(scenario)) {
  health_.resize(scenario.devices.size());
  reported_device_status_.resize(scenario.devices.size(), DeviceStatus::kAlive);  // so that one that is missing is told
  for (const char* name :
       {"peak_force_N", "force_N", "direct_mean_ms", "t1_mean_ms", "filter_status", "misses", "loop_delay_ms",
        "loop_jitter_ms", "allowed_N_per_m", "least_share", "energy_J", "made_passive"}) {
    figures_.items.push_back({name, 0.0});
  }
  first_share_ = figures_.items.size();
  for (const scene::Device& device : scenario.devices) {
    for (const std::string& name : {core::StiffnessLimitName(device.role), core::DampingLimitName(device.role),
                                    core::TurnDampingLimitName(device.role)}) {
      figures_.items.push_back({name, 0.0});
    }
  }
  first_muscle_ = figures_.items.size();
  for (std::size_t role = 0; role < scenario.devices.size(); ++role) {
    if (bridge->muscle(role) == nullptr) continue;
    figures_.items.push_back({core::MuscleShareName(scenario.devices[role].role), 0.0});
  }
  first_tip_ = figures_.items.size();
  for (const scene::Device& device : scenario.devices) {
    if (bridge->tip(0) == nullptr) break;
    for (const char* name : core::kGuideFigures) figures_.items.push_back({core::GuideName(device.role, name), 0.0});
  }
  for (std::unique_ptr<HeadTracker>& head : heads) heads_.push_back({std::move(head), {}, {}});
  lost_.reserve(64);
  core::ReserveTexts(&received_event_);
}

void NodeLoop::Declare() {
  for (const scene::Device& device : scenario_.devices) {
    commands_.push_back(&node_->ReadLatest<core::DeviceCommand>(bus::DeviceCommandTopic(device.role)));
    proxies_.push_back(&node_->ReadLatest<core::HapticProxy>(bus::HapticProxyTopic(device.role)));
    reactions_.push_back(&node_->ReadLatest<core::Reaction>(bus::ReactionTopic(device.role)));
    writers_.push_back(node_->WriteLatest<core::DeviceState>(bus::DeviceStateTopic(device.role)));
  }
  for (std::size_t i = 0; i < heads_.size(); ++i) {
    const std::string& user = scenario_.users[i].name;
    heads_[i].writer = node_->WriteLatest<core::HeadState>(bus::HeadTopic(user));
    std::printf("head of %s: %s\n", user.c_str(), heads_[i].tracker->description());
  }
  for (const scene::Device& device : scenario_.devices) {
    const std::size_t role = joints_writers_.size();
    joints_writers_.emplace_back();
    if (bridge_->device(role).is_robot()) {
      joints_writers_.back() = node_->WriteLatest<core::DeviceJoints>(bus::DeviceJointsTopic(device.role));
    }
    health_writers_.push_back(node_->WriteState<core::DeviceHealth>(bus::DeviceHealthTopic(device.role)));
  }
  if (tactiles_) tactiles_->Declare(node_);
  physics_ = &node_->ReadLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  logic_ = &node_->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
  for (const std::string& viewer : viewers_) {
    hands_.push_back(&node_->ReadLatest<core::HandInput>(bus::HandInputTopic(viewer)));
  }
  figures_writer_ = node_->WriteState<bus::Figures>(bus::FiguresTopic("device_bridge"));
  node_->ReadEvents();
}

void NodeLoop::Run(const std::atomic<bool>& stop) {
  bus::PeriodicLoop loop(core::kTick_ns);
  while (!stop.load(std::memory_order_relaxed)) {
    // Until the next tick, pass each command to the device as soon as it arrives.
    while (core::MonotonicNow_ns() < loop.next_due_ns()) {
      node_->Wait(loop.next_due_ns());
      ForwardCommands();
    }
    const bus::TickInfo tick = loop.Advance(core::MonotonicNow_ns());
    ++ticks_;
    skipped_ += tick.skipped;
    wake_delay_.Add(tick.woke_ns - tick.scheduled_ns);
    if (tick.woke_ns - tick.scheduled_ns > kMiss_ns) ++misses_;
    Step();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    ReportFaults(now_ns);
    ReportDevices(now_ns);
    PublishFigures(now_ns);
  }
}

void NodeLoop::ForwardCommands() {
  for (std::size_t role = 0; role < commands_.size(); ++role) {
    if (!commands_[role]->is_fresh()) continue;
    bridge_->AcceptCommand(role, commands_[role]->value(), commands_[role]->received_ns(), core::MonotonicNow_ns());
  }
}

void NodeLoop::Step() {
  inputs_.now_ns = core::MonotonicNow_ns();
  inputs_.proxies.clear();
  inputs_.grasped_objects.clear();
  for (std::size_t role = 0; role < proxies_.size(); ++role) {
    inputs_.proxies.push_back(proxies_[role]->value());
    inputs_.grasped_objects.push_back(reactions_[role]->has_value() ? reactions_[role]->value().grasped_object
                                                                    : core::kNoObject);
  }
  inputs_.physics = physics_->has_value() ? &physics_->value() : nullptr;
  inputs_.logic = logic_->has_value() ? &logic_->value() : nullptr;
  inputs_.hands.clear();
  for (const auto* hand : hands_) inputs_.hands.push_back(hand->value());
  bridge_->Step(inputs_, &outputs_);
  for (std::size_t role = 0; role < writers_.size(); ++role) {
    core::DeviceState& state = outputs_.states[role];
    state.header.direct.Add(core::Stage::kDeviceSend, core::MonotonicNow_ns());
    writers_[role].Send(state);
    force_log_.Add(static_cast<std::uint32_t>(role), inputs_.now_ns, outputs_.applied[role]);
  }
  step_duration_.Add(core::MonotonicNow_ns() - inputs_.now_ns);
  SendJoints();
  SendHeads();
  if (tactiles_) tactiles_->Step(inputs_);
}

void NodeLoop::SendJoints() {
  if (ticks_ % kTicksPerJoints != 0) return;
  for (std::size_t role = 0; role < joints_writers_.size(); ++role) {
    if (joints_writers_[role] && bridge_->Joints(role, &joints_)) joints_writers_[role]->Send(joints_);
  }
}

// After the samples: no force waits for a picture.
void NodeLoop::SendHeads() {
  if (ticks_ % kTicksPerHead != 0) return;
  for (Head& head : heads_) {
    const std::optional<core::Pose> X_RH = head.tracker->Read(inputs_.now_ns);
    ReportHead(head.watch.Note(inputs_.now_ns, X_RH.has_value()), *head.tracker);
    if (!X_RH) continue;
    core::HeadState state;
    state.sample_ns = inputs_.now_ns;
    state.X_RH = *X_RH;
    state.is_simulated = head.tracker->is_simulated();
    head.writer.Send(state);
  }
}

// Prints and allocates only when a head comes or goes. A simulated one is always there.
void NodeLoop::ReportHead(HeadWatch::News news, const HeadTracker& tracker) {
  if (news == HeadWatch::News::kNone || tracker.is_simulated()) return;
  const bool is_found = news == HeadWatch::News::kFound;
  const std::string detail = std::string(tracker.description()) + (is_found ? " is tracked" : " is not tracked");
  node_->Emit({inputs_.now_ns, "device_bridge", is_found ? "head_found" : "head_lost", detail});
  std::printf("%s\n", detail.c_str());
  std::fflush(stdout);
}

// Runs after the samples were sent, and prints only when a fault begins or ends.
void NodeLoop::ReportFaults(std::int64_t now_ns) {
  for (std::size_t role = 0; role < outputs_.filter_status.size(); ++role) {
    const std::uint32_t status = outputs_.filter_status[role];
    const std::uint32_t changed = status ^ reported_status_[role];
    reported_status_[role] = status;
    const auto report = [&](core::Event* event) {
      event->time_ns = now_ns;
      node_->Emit(*event);
      std::printf("%s: %s\n", scenario_.devices[role].role.c_str(), event->detail.c_str());
      std::fflush(stdout);
    };
    if ((changed & kSilent) != 0) report((status & kSilent) != 0 ? &silent_event_ : &back_event_);
    if ((changed & kNotFinite) != 0 && (status & kNotFinite) != 0) report(&fault_event_);
  }
  while (node_->PollEvent(&received_event_)) {
    if (received_event_.name != "node_lost") continue;
    if (lost_.size() < lost_.capacity()) lost_.push_back(received_event_.detail);
    std::printf("lost: %s\n", received_event_.detail.c_str());
    std::fflush(stdout);
  }
}

// Prints and allocates only when a device comes or goes.
void NodeLoop::ReportDevices(std::int64_t now_ns) {
  for (std::size_t role = 0; role < health_.size(); ++role) {
    const DeviceHealth& health = bridge_->health(role);
    DeviceStatus& reported = reported_device_status_[role];
    if (health.status == reported) continue;
    const bool is_found = health.status == DeviceStatus::kAlive;
    const oos_device_description& description = bridge_->device(role).description();
    std::string detail = scenario_.devices[role].role + ": " + description.name;
    if (description.serial[0] != 0) detail += std::string(" ") + description.serial;
    if (description.name[0] == 0) detail += scenario_.devices[role].type + " device";
    detail += std::string(" is ") + NameOf(health.status);
    detail += StepsSince(bridge_->presence(role), is_found);
    if (health.why[0] != 0) detail += std::string(": ") + health.why.data();
    reported = health.status;
    node_->Emit({now_ns, "device_bridge", is_found ? "device_found" : "device_lost", detail});
    std::printf("%s\n", detail.c_str());
    std::fflush(stdout);
  }
}

// Beside the figures, twice a second.
void NodeLoop::PublishHealth() {
  for (std::size_t role = 0; role < health_.size(); ++role) {
    const DeviceHealth& health = bridge_->health(role);
    const Device& device = bridge_->device(role);
    core::DeviceHealth& message = health_[role];
    message.role_index = static_cast<std::uint8_t>(role);
    message.name = device.description().name;
    message.serial = device.description().serial;
    message.status = NameOf(health.status);
    message.quality = NameOf(health.quality);
    message.why = health.why.data();
    message.rate_hz = health.link.rate_hz;
    message.jitter_s = health.link.jitter_s;
    message.loss = health.link.loss;
    message.round_trip_s = health.link.round_trip_s;
    message.is_engaged = outputs_.states[role].is_engaged;
    message.is_simulated = device.is_simulated();
    message.is_calibrated = health.is_calibrated;
    message.residual_m = health.residual_m;
    health_writers_[role].Set(message);
  }
}

void NodeLoop::PublishFigures(std::int64_t now_ns) {
  if (now_ns < next_figures_ns_ || outputs_.applied.empty()) return;
  next_figures_ns_ = now_ns + (bridge_->tip(0) != nullptr ? kTipsPeriod_ns : kFiguresPeriod_ns);
  double peak_N = 0.0;
  for (std::size_t role = 0; role < outputs_.applied.size(); ++role) {
    peak_N = std::max(peak_N, bridge_->figures(role).peak_force_N);
  }
  figures_.items[0].value = peak_N;
  figures_.items[1].value = glm::length(outputs_.applied[0].force_N);
  figures_.items[2].value = bridge_->echo_log().mean_ms(EchoLog::Chain::kDirect);
  figures_.items[3].value = bridge_->echo_log().mean_ms(EchoLog::Chain::kThroughPhysics);
  figures_.items[4].value = outputs_.filter_status[0];
  figures_.items[5].value = static_cast<double>(misses_);
  const RoleFigures first = bridge_->figures(0);
  figures_.items[6].value = 1e3 * first.loop_delay_s;
  figures_.items[7].value = 1e3 * first.loop_jitter_s;
  figures_.items[8].value = first.allowed.stiffness_N_per_m;
  figures_.items[9].value = first.least_stiffness_share;
  figures_.items[10].value = first.energy_J;
  figures_.items[11].value = static_cast<double>(first.samples_made_passive);
  for (std::size_t role = 0; role < outputs_.applied.size(); ++role) {
    const std::size_t first_figure = first_share_ + 3 * role;
    figures_.items[first_figure].value = bridge_->stiffness_share(role);
    figures_.items[first_figure + 1].value = bridge_->allowed(role).damping_N_s_per_m;
    figures_.items[first_figure + 2].value = bridge_->allowed(role).damping_Nm_s_per_rad;
  }
  TakeMuscles();
  TakeTips();
  figures_writer_.Set(figures_);
  if (now_ns < next_health_ns_) return;
  next_health_ns_ = now_ns + kFiguresPeriod_ns;
  PublishHealth();
}

void NodeLoop::TakeMuscles() {
  std::size_t figure = first_muscle_;
  for (std::size_t role = 0; role < scenario_.devices.size(); ++role) {
    if (const MuscleGrip* muscle = bridge_->muscle(role)) {
      figures_.items[figure++].value = muscle->share().value_or(-1.0);
    }
  }
}

void NodeLoop::TakeTips() {
  auto figure = figures_.items.begin() + static_cast<std::ptrdiff_t>(first_tip_);
  for (std::size_t role = 0; figure != figures_.items.end(); ++role) {
    const Tip& tip = *bridge_->tip(role);
    for (const double value : {static_cast<double>(tip.kind), tip.way_W_m.x, tip.way_W_m.y, tip.way_W_m.z,
                               tip.turn_W_rad.x, tip.turn_W_rad.y, tip.turn_W_rad.z}) {
      (figure++)->value = value;
    }
  }
}

core::Result<void> NodeLoop::WriteReport(const std::filesystem::path& folder, bool is_realtime) const {
  nlohmann::json report = MakeReport(*bridge_);
  report["is_realtime"] = is_realtime;
  report["ticks"] = ticks_;
  report["misses"] = misses_;
  report["skipped"] = skipped_;
  report["wake_delay_p99_us"] = wake_delay_.p99_ns() * 1e-3;
  report["wake_delay_max_us"] = static_cast<double>(wake_delay_.max_ns()) * 1e-3;
  report["step_p50_us"] = step_duration_.p50_ns() * 1e-3;
  report["step_p99_us"] = step_duration_.p99_ns() * 1e-3;
  report["step_max_us"] = static_cast<double>(step_duration_.max_ns()) * 1e-3;
  report["nodes_lost"] = lost_;
  report["tactile"] = tactiles_ ? tactiles_->Report() : nlohmann::json::array();
  report["clock_bounds_ns"] = bus::ClockBounds(node_->Peers());
  const bus::Counters counters = node_->counters();
  report["bus"] = {{"sent", counters.sent}, {"received", counters.received}, {"dropped", counters.dropped}};
  const std::filesystem::path file = folder / "device_bridge.json";
  std::ofstream stream(file);
  stream << report.dump(2) << '\n';
  stream.flush();
  if (!stream) return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be written. Does the folder exist?");
  if (auto written = force_log_.Write(folder / "device_bridge_force.csv"); !written) return written;
  return WriteLatencyTable(bridge_->echo_log(), folder / "device_bridge_latency.csv");
}

}  // namespace device_bridge
