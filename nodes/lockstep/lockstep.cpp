#include "nodes/lockstep/lockstep.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>

#include "bus/rt/latency_stats.hpp"
#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "core/hand_limits.hpp"
#include "nodes/device_bridge/device_bridge.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/haptic_physics_node/hand_over.hpp"
#include "nodes/lockstep/state_hash.hpp"
#include "nodes/lockstep/step_recording.hpp"
#include "nodes/logic_node/logic_node.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/limit_reached.hpp"

namespace lockstep {
namespace {

constexpr std::uint64_t kLogicPeriod_ticks = 10;
constexpr std::uint64_t kTracePeriod_ticks = 10;
constexpr double kProgressPeriod_s = 5.0;

Times TimesOf(const bus::LatencyStats& times) {
  return {times.p50_ns() * 1e-3, times.p99_ns() * 1e-3, times.Percentile_ns(0.9999) * 1e-3,
          static_cast<double>(times.max_ns()) * 1e-3};
}

class Lockstep {
 public:
  Lockstep(const scene::Scenario& scenario, const Options& options)
      : scenario_(scenario), options_(options), pool_(options.workers) {
    outcome_.seed = options.seed.value_or(scenario.seed);
    scenario_.seed = outcome_.seed;
  }

  core::Result<Outcome> Run() {
    if (const auto made = MakeNodes(); !made) return core::Fail(made.error().code, made.error().detail);
    if (const auto opened = OpenTrace(); !opened) return core::Fail(opened.error().code, opened.error().detail);
    const double limit_s = options_.duration_s.value_or(scenario_.duration_limit_s);
    const auto limit_ticks = static_cast<std::uint64_t>(limit_s / core::kTick_s);
    changes_ = options_.parameters;
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (outcome_.ticks < limit_ticks && !IsOver()) {
      if (const auto begun = BeginSteps(); !begun) return core::Fail(begun.error().code, begun.error().detail);
      Tick();
      if (outcome_.ticks != options_.restart_physics_tick) continue;
      if (const auto restarted = RestartPhysics(); !restarted) {
        return core::Fail(restarted.error().code, restarted.error().detail);
      }
    }
    if (!IsOver()) outcome_.why = scene::LimitReached(limit_s, logic_out_.status.step);
    Finish(begin_ns);
    if (steps_ != nullptr) {
      if (const auto closed = steps_->Close(); !closed) return core::Fail(closed.error().code, closed.error().detail);
    }
    return outcome_;
  }

 private:
  core::Result<void> MakeNodes();
  core::Result<void> MakePhysics();
  core::Result<void> MakeHaptic();
  core::Result<void> RestartPhysics();
  core::Result<void> BeginSteps();
  core::Result<void> OpenTrace();
  void Tick();
  void StepBridge();
  void GatherHapticChanges();
  void StepHaptic();
  void StepPhysics();
  void Reevaluate();
  void StepLogic();
  // Node::Step, watched.
  template <class Node, class Inputs, class Outputs>
  void StepNode(std::string_view name, Node* node, const Inputs& inputs, Outputs* outputs) {
    if (options_.watch_steps) options_.watch_steps(name, true);
    node->Step(inputs, outputs);
    if (options_.watch_steps) options_.watch_steps(name, false);
  }
  void FollowSteps();
  void ReportProgress() const;
  void WriteTraceRow();
  void Finish(std::int64_t begin_ns);

  void Say(const std::string& line) const {
    if (options_.say) options_.say(line);
  }
  [[nodiscard]] bool IsOver() const {
    return outcome_.is_completed || !outcome_.why.empty() ||
           (options_.interrupted != nullptr && options_.interrupted->load() != 0);
  }
  [[nodiscard]] double now_s() const { return static_cast<double>(outcome_.ticks) * core::kTick_s; }

  scene::Scenario scenario_;
  const Options& options_;
  bus::WorkerPool pool_;
  Outcome outcome_;
  StateHash hash_;
  std::ofstream trace_;

  std::unique_ptr<device_bridge::DeviceBridge> bridge_;
  std::unique_ptr<haptic_node::HapticNode> haptic_;
  std::unique_ptr<physics_node::PhysicsNode> physics_;
  std::unique_ptr<logic_node::LogicNode> logic_;
  device_bridge::Outputs bridge_out_;
  haptic_node::Step haptic_step_;
  haptic_node::Step reevaluation_;
  physics_node::Step physics_step_;
  logic_node::Step logic_step_;
  haptic_node::Outputs& haptic_out_ = haptic_step_.outputs;
  physics_node::Outputs& physics_out_ = physics_step_.outputs;
  logic_node::Outputs& logic_out_ = logic_step_.outputs;
  std::unique_ptr<StepRecording> steps_;  // null: not recorded, or not yet

  // Hand-over: what arrived over the "bus" by now. Messages that go forward (device to haptic to physics) are of this
  // tick, those that go back are of the tick before.
  core::FixedVector<core::DeviceCommand, device_bridge::kMaxRoles> last_commands_;
  core::FixedVector<core::HapticProxy, device_bridge::kMaxRoles> last_proxies_;
  haptic_physics_node::HandOver hand_over_;
  const core::PhysicsState& last_state_ = hand_over_.answer.state;
  const core::FixedVector<core::Reaction, haptic_node::kMaxRoles>& last_reactions_ = hand_over_.answer.reactions;
  std::vector<core::ParameterChange> changes_;
  std::vector<core::ParameterChange> haptic_changes_;  // these, and the hands' limits that the bridge found
  std::vector<double> hand_limits_;                    // three per role, as passed on; 0: none
  std::vector<core::Event> events_;
  std::int64_t now_ns_ = 0;

  bus::LatencyStats haptic_ns_, contact_ns_, haptic_cpu_ns_, contact_cpu_ns_, physics_ns_;
  std::string step_;
  double next_progress_s_ = 0.0;
};

core::Result<void> Lockstep::MakeNodes() {
  auto bridge = device_bridge::DeviceBridge::Create(scenario_, outcome_.seed);
  if (!bridge) return core::Fail(bridge.error().code, bridge.error().detail);
  bridge_ = std::move(*bridge);
  if (auto made = MakeHaptic(); !made) return made;
  if (auto made = MakePhysics(); !made) return made;
  auto logic = logic_node::LogicNode::Create(scenario_);
  if (!logic) return core::Fail(logic.error().code, logic.error().detail);
  logic_ = std::move(*logic);
  hand_over_.cycle.contacts.resize(scenario_.pairs.size());
  return {};
}

core::Result<void> Lockstep::MakeHaptic() {
  haptic_node::Options haptic_options;
  haptic_options.collision.cache = options_.cache;
  haptic_options.collision.progress = [this](const std::string& line) { Say(line); };
  auto haptic = haptic_node::HapticNode::Create(scenario_, pool_, haptic_options);
  if (!haptic) return core::Fail(haptic.error().code, haptic.error().detail);
  haptic_ = std::move(*haptic);
  haptic_->PrepareOutputs(&haptic_out_);
  return {};
}

core::Result<void> Lockstep::MakePhysics() {
  physics_node::Options physics_options;
  physics_options.collision.cache = options_.cache;
  physics_options.collision.progress = [this](const std::string& line) { Say(line); };
  physics_options.workers = &pool_;
  auto physics = physics_node::PhysicsNode::Create(scenario_, physics_options);
  if (!physics) return core::Fail(physics.error().code, physics.error().detail);
  physics_ = std::move(*physics);
  return {};
}

// Nothing of the old node is left but the file.
core::Result<void> Lockstep::RestartPhysics() {
  physics_node::Snapshot snapshot;
  physics_->Save(&snapshot);
  if (auto written = physics_node::WriteSnapshot(options_.checkpoint, physics_->content_digest(), snapshot); !written) {
    return written;
  }
  physics_.reset();
  if (auto made = MakePhysics(); !made) return made;
  physics_node::Snapshot read;
  auto restored = physics_node::ReadSnapshot(options_.checkpoint, physics_->content_digest(), &read);
  return restored ? physics_->Restore(&read) : restored;
}

// haptic_node has no checkpoint, so a recording that begins later begins with a new one, as after its death.
core::Result<void> Lockstep::BeginSteps() {
  if (steps_ != nullptr || options_.steps.empty() || now_s() < options_.steps_from_s) return {};
  if (outcome_.ticks > 0) {
    if (auto made = MakeHaptic(); !made) return made;
  }
  auto recording = StepRecording::Create(options_.steps, scenario_, *physics_, *logic_);
  if (!recording) return core::Fail(recording.error().code, recording.error().detail);
  steps_ = std::move(*recording);
  return {};
}

void Lockstep::Tick() {
  // The clock starts at one tick: time 0 means "never" in some messages.
  now_ns_ = static_cast<std::int64_t>(outcome_.ticks + 1) * core::kTick_ns;
  StepBridge();
  StepHaptic();
  StepPhysics();
  Reevaluate();
  changes_.clear();
  if (outcome_.ticks % kLogicPeriod_ticks == 0) StepLogic();
  if (trace_.is_open() && outcome_.ticks % kTracePeriod_ticks == 0) WriteTraceRow();
  ++outcome_.ticks;
}

void Lockstep::StepBridge() {
  device_bridge::Inputs inputs;
  inputs.now_ns = now_ns_;
  inputs.commands = last_commands_;
  inputs.command_received_ns.resize(last_commands_.size());
  for (std::int64_t& received_ns : inputs.command_received_ns) received_ns = now_ns_;
  inputs.proxies = last_proxies_;
  inputs.physics = last_state_.header.sequence != 0 ? &last_state_ : nullptr;
  for (const core::Reaction& reaction : last_reactions_) inputs.grasped_objects.push_back(reaction.grasped_object);
  inputs.logic = &logic_out_.status;
  StepNode("device_bridge", bridge_.get(), inputs, &bridge_out_);
  for (core::DeviceState& state : bridge_out_.states) {
    state.header.sequence = outcome_.ticks + 1;
    state.header.publish_ns = now_ns_;
    hash_.Add(state);
  }
  for (const core::Wrench& applied : bridge_out_.applied) {
    outcome_.peak_force_N = std::max(outcome_.peak_force_N, glm::length(applied.force_N));
  }
}

// As haptic_node's loop does it with the bridge's figures.
void Lockstep::GatherHapticChanges() {
  haptic_changes_ = changes_;
  hand_limits_.resize(3 * scenario_.devices.size());
  const auto limit = [this](const std::string& name, double value, double* known) {
    if (value <= 0.0 || value == *known || !haptic_->AcceptsParameter({name, value})) return;
    *known = value;
    haptic_changes_.push_back({name, value});
  };
  for (std::size_t role = 0; role < scenario_.devices.size(); ++role) {
    const std::string& name = scenario_.devices[role].role;
    double* known = &hand_limits_[3 * role];
    if (known[0] == 0.0) known[0] = 1.0;  // what haptic_node begins with
    limit(core::StiffnessLimitName(name), std::min(bridge_->stiffness_share(role), 1.0), &known[0]);
    limit(core::DampingLimitName(name), bridge_->allowed(role).damping_N_s_per_m, &known[1]);
    limit(core::TurnDampingLimitName(name), bridge_->allowed(role).damping_Nm_s_per_rad, &known[2]);
  }
}

void Lockstep::StepHaptic() {
  haptic_node::Inputs& inputs = haptic_step_.inputs;
  inputs.now_ns = now_ns_;
  inputs.devices = bridge_out_.states;
  inputs.physics = last_state_.header.sequence != 0 ? &last_state_ : nullptr;
  inputs.reactions = last_reactions_;
  GatherHapticChanges();
  inputs.changes = haptic_changes_.data();
  inputs.num_changes = haptic_changes_.size();
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const std::int64_t cpu_begin_ns = core::ThreadCpuNow_ns();
  StepNode("haptic_node", haptic_.get(), inputs, &haptic_out_);
  const std::int64_t cpu_ns = core::ThreadCpuNow_ns() - cpu_begin_ns;
  const std::int64_t took_ns = core::MonotonicNow_ns() - begin_ns;
  if (steps_ != nullptr) steps_->haptic.Record(haptic_->cycle(), now_ns_, haptic_step_);
  haptic_ns_.Add(took_ns);
  haptic_cpu_ns_.Add(cpu_ns);
  if (haptic_out_.is_in_contact) {
    contact_ns_.Add(took_ns);
    contact_cpu_ns_.Add(cpu_ns);
    ++outcome_.contact_cycles;
  }
  for (core::DeviceCommand& command : haptic_out_.commands) {
    command.header.sequence = outcome_.ticks + 1;
    command.header.publish_ns = now_ns_;
    outcome_.peak_command_N = std::max(outcome_.peak_command_N, glm::length(command.F_Do_W.force_N));
    hash_.Add(command);
  }
  hand_over_.TakeProxies(outcome_.ticks + 1, now_ns_, &haptic_out_);
  if (!options_.loses_physics_wrench) hand_over_.TakeContacts(outcome_.ticks + 1, now_ns_, &haptic_out_);
  haptic_node::Counters& sum = outcome_.work;
  const haptic_node::Counters& now = haptic_out_.counters;
  sum.pairs_considered += now.pairs_considered;
  sum.pairs_inactive += now.pairs_inactive;
  sum.pairs_coherent += now.pairs_coherent;
  sum.pairs_tested += now.pairs_tested;
  sum.pairs_in_contact += now.pairs_in_contact;
  sum.spheres_tested += now.spheres_tested;
  sum.points_tested += now.points_tested;
  sum.points_colliding += now.points_colliding;
  last_commands_ = haptic_out_.commands;
  last_proxies_ = haptic_out_.proxies;
}

void Lockstep::StepPhysics() {
  physics_node::Inputs& inputs = physics_step_.inputs;
  inputs.now_ns = now_ns_;
  inputs.proxies = hand_over_.cycle.proxies;
  inputs.contacts = hand_over_.cycle.contacts.data();
  inputs.num_contacts = hand_over_.cycle.contacts.size();
  inputs.changes = changes_.data();
  inputs.num_changes = changes_.size();
  const std::int64_t begin_ns = core::ThreadCpuNow_ns();
  StepNode("physics_node", physics_.get(), inputs, &physics_out_);
  physics_ns_.Add(core::ThreadCpuNow_ns() - begin_ns);
  if (steps_ != nullptr) steps_->physics.Record(physics_->tick(), now_ns_, physics_step_);
  hand_over_.TakeAnswer(outcome_.ticks + 1, now_ns_, &physics_out_);
  hash_.Add(physics_out_.state);
  if (options_.follow) options_.follow(physics_out_.state);
  events_.insert(events_.end(), physics_out_.events.begin(), physics_out_.events.end());
}

// The bridge takes a role's newest command with its next sample.
void Lockstep::Reevaluate() {
  haptic_node::Inputs& inputs = reevaluation_.inputs;
  inputs.now_ns = now_ns_;
  inputs.devices = bridge_out_.states;
  inputs.physics = &last_state_;
  inputs.reactions = last_reactions_;
  if (!haptic_->IsToReevaluate(inputs)) return;
  if (options_.watch_steps) options_.watch_steps("haptic_node", true);
  haptic_->Reevaluate(inputs, &reevaluation_.outputs);
  if (options_.watch_steps) options_.watch_steps("haptic_node", false);
  if (steps_ != nullptr) steps_->reevaluation.Record(haptic_->cycle(), now_ns_, reevaluation_);
  for (std::size_t r = 0; r < reevaluation_.outputs.commands.size(); ++r) {
    core::DeviceCommand& command = reevaluation_.outputs.commands[r];
    if (!command.header.through_physics.valid()) continue;
    command.header.sequence = outcome_.ticks + 1;
    command.header.publish_ns = now_ns_;
    outcome_.peak_command_N = std::max(outcome_.peak_command_N, glm::length(command.F_Do_W.force_N));
    hash_.Add(command);
    last_commands_[r] = command;
  }
}

void Lockstep::StepLogic() {
  logic_node::Inputs& inputs = logic_step_.inputs;
  inputs.now_ns = now_ns_;
  inputs.physics = &last_state_;
  inputs.grasped_objects.clear();
  for (const core::Reaction& reaction : last_reactions_) inputs.grasped_objects.push_back(reaction.grasped_object);
  inputs.events = events_;
  events_.clear();
  StepNode("logic_node", logic_.get(), inputs, &logic_out_);
  if (steps_ != nullptr) steps_->logic.Record(outcome_.ticks / kLogicPeriod_ticks + 1, now_ns_, logic_step_);
  changes_ = logic_out_.changes;
  FollowSteps();
}

void Lockstep::FollowSteps() {
  const core::LogicStatus& status = logic_out_.status;
  if (status.step != step_) {
    char line[160];
    std::snprintf(line, sizeof line, "%7.2f s  step %s", now_s(), status.step.c_str());
    Say(line);
    step_ = status.step;
    next_progress_s_ = now_s() + kProgressPeriod_s;
  } else if (now_s() >= next_progress_s_) {
    next_progress_s_ += kProgressPeriod_s;
    ReportProgress();
  }
  if (status.is_failed) {
    outcome_.why = status.why.empty() ? "failed in step " + status.step : status.why;
  } else if (status.is_final) {
    outcome_.is_completed = true;
  }
}

void Lockstep::ReportProgress() const {
  const core::LogicStatus& status = logic_out_.status;
  std::string text;
  char part[200];
  for (std::size_t i = 0; i < scenario_.devices.size(); ++i) {
    const glm::dvec3 p = bridge_out_.states[i].X_WD.translation;
    const std::uint16_t held = last_reactions_.size() > i ? last_reactions_[i].grasped_object : core::kNoObject;
    std::snprintf(part, sizeof part, "  %s at %.3f %.3f %.3f, %.1f N, opening %.1f mm%s%s",
                  scenario_.devices[i].role.c_str(), p.x, p.y, p.z, glm::length(bridge_out_.applied[i].force_N),
                  1e3 * bridge_out_.states[i].opening_m, held == core::kNoObject ? "" : ", holds ",
                  held == core::kNoObject ? "" : scenario_.objects[held].name.c_str());
    text += part;
  }
  std::snprintf(part, sizeof part, "%7.2f s  in %s", now_s(), status.step.c_str());
  Say(part + text);
}

void Lockstep::Finish(std::int64_t begin_ns) {
  outcome_.wall_s = static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9;
  outcome_.simulated_s = now_s();
  outcome_.hash = hash_.value();
  outcome_.impulse_balance = physics_->impulse_balance().relative();
  outcome_.used_stiffness_share = haptic_->least_stiffness_share();
  for (std::size_t role = 0; role < scenario_.devices.size(); ++role) {
    const device_bridge::RoleFigures hand = bridge_->figures(role);
    outcome_.least_energy_J = std::min(outcome_.least_energy_J, hand.least_energy_J);
    outcome_.share_made_passive = std::max(outcome_.share_made_passive, hand.share_made_passive());
    outcome_.least_stiffness_share =
        role == 0 ? hand.least_stiffness_share : std::min(outcome_.least_stiffness_share, hand.least_stiffness_share);
  }
  outcome_.haptic = TimesOf(haptic_ns_);
  outcome_.haptic_cpu = TimesOf(haptic_cpu_ns_);
  outcome_.contact = TimesOf(contact_ns_);
  outcome_.contact_cpu = TimesOf(contact_cpu_ns_);
  outcome_.physics_p50_us = physics_ns_.p50_ns() * 1e-3;
  outcome_.physics_p99_us = physics_ns_.p99_ns() * 1e-3;
  outcome_.physics_max_us = static_cast<double>(physics_ns_.max_ns()) * 1e-3;
  for (const logic_node::StepRecord& record : logic_->steps()) {
    outcome_.steps.push_back({record.name, record.is_completed, record.seconds, record.is_completed ? "" : record.why});
  }
  if (outcome_.why.empty() && !outcome_.is_completed) outcome_.why = "interrupted";
}

core::Result<void> Lockstep::OpenTrace() {
  if (options_.trace.empty()) return {};
  trace_.open(options_.trace);
  if (!trace_) return core::Fail(core::ErrorCode::kIo, "cannot write " + options_.trace.string());
  trace_ << "time_s,step";
  for (const scene::Device& device : scenario_.devices) {
    for (const char* name :
         {"D_x", "D_y", "D_z", "D_rx", "D_ry", "D_rz", "C_x",    "C_y",        "C_z",        "opening",
          "F_x", "F_y", "F_z", "T_x",  "T_y",  "T_z",  "grip_N", "reaction_N", "in_contact", "grasped"}) {
      trace_ << ',' << device.role << '.' << name;
    }
  }
  for (const scene::Mechanism& mechanism : scenario_.mechanisms) {
    trace_ << ',' << mechanism.name << ".state," << mechanism.name << ".position," << mechanism.name << ".force";
  }
  for (const scene::Object& object : scenario_.objects) {
    if (object.owner != scene::Owner::kPhysics) continue;
    for (const char* name : {"x", "y", "z", "rx", "ry", "rz"}) trace_ << ',' << object.name << '.' << name;
  }
  trace_ << ",pairs_in_contact,deepest_pair,deepest_mm\n";
  return {};
}

void Lockstep::WriteTraceRow() {
  const auto vector = [this](const glm::dvec3& v) { trace_ << ',' << v.x << ',' << v.y << ',' << v.z; };
  const auto pose = [&](const core::Pose& X) {
    vector(X.translation);
    vector(core::RotationVector(X.rotation));
  };
  trace_ << now_s() << ',' << logic_out_.status.step;
  for (std::size_t i = 0; i < scenario_.devices.size(); ++i) {
    pose(bridge_out_.states[i].X_WD);
    vector(haptic_out_.proxies[i].X_WC.translation);
    trace_ << ',' << bridge_out_.states[i].opening_m;
    vector(bridge_out_.applied[i].force_N);
    vector(bridge_out_.applied[i].torque_Nm);
    trace_ << ',' << haptic_out_.commands[i].grip_force_N;
    const core::Reaction reaction = i < last_reactions_.size() ? last_reactions_[i] : core::Reaction{};
    trace_ << ',' << glm::length(reaction.F_Do_W.force_N) << ',' << (haptic_out_.proxies[i].is_in_contact ? 1 : 0)
           << ','
           << (reaction.grasped_object == core::kNoObject ? "" : scenario_.objects[reaction.grasped_object].name);
  }
  std::vector<core::MechanismState> mechanisms(scenario_.mechanisms.size());
  for (const core::MechanismState& state : last_state_.mechanisms) mechanisms[state.mechanism] = state;
  for (const core::MechanismState& state : mechanisms)
    trace_ << ',' << state.state << ',' << state.position << ',' << state.force;
  std::vector<core::Pose> poses(scenario_.objects.size());
  for (const core::BodyState& body : last_state_.bodies) poses[body.object] = body.X_WO;
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    if (scenario_.objects[i].owner == scene::Owner::kPhysics) pose(poses[i]);
  }
  const std::size_t none = haptic_out_.contacts.size();
  std::size_t deepest = none;
  for (std::size_t i = 0; i < haptic_out_.contacts.size(); ++i) {
    if (!haptic_out_.contacts[i].is_in_contact) continue;
    if (deepest == none || haptic_out_.contacts[i].signed_distance_m < haptic_out_.contacts[deepest].signed_distance_m)
      deepest = i;
  }
  trace_ << ',' << haptic_out_.counters.pairs_in_contact << ',';
  if (deepest < none) {
    trace_ << scenario_.PairName(deepest) << ',' << -1e3 * haptic_out_.contacts[deepest].signed_distance_m;
  } else {
    trace_ << ',';
  }
  trace_ << '\n';
}

}  // namespace

core::Result<Outcome> Run(const scene::Scenario& scenario, const Options& options) {
  Lockstep lockstep(scenario, options);
  return lockstep.Run();
}

}  // namespace lockstep
