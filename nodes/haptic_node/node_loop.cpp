#include "nodes/haptic_node/node_loop.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "bus/membership/clock_bounds.hpp"
#include "bus/rt/stolen_time.hpp"
#include "core/clock.hpp"
#include "core/hand_limits.hpp"
#include "core/messages/reserve_texts.hpp"

namespace haptic_node {
namespace {

constexpr std::int64_t kGather_ns = 200'000;     // wait for other roles after the first sample: a fifth of the period
constexpr std::int64_t kSilence_ns = 2'000'000;  // without samples for two periods the timer takes over
constexpr std::int64_t kFiguresPeriod_ns = 500'000'000;
constexpr std::size_t kMaxChangesPerStep = 32;
// A sample older than this on arrival was stamped by another host's clock, so its arrival time is used.
constexpr std::int64_t kPlausibleAge_ns = 20'000'000;

double Microseconds(double ns) {
  return ns * 1e-3;
}

void AddFigures(const CycleStatistics& statistics, const std::string& prefix, nlohmann::json* report) {
  (*report)[prefix + "cycles"] = statistics.durations.count();
  (*report)[prefix + "misses"] = statistics.misses;
  const auto add = [report](const std::string& name, const bus::LatencyStats& times) {
    (*report)[name + "p50_us"] = Microseconds(times.p50_ns());
    (*report)[name + "p99_us"] = Microseconds(times.p99_ns());
    (*report)[name + "p9999_us"] = Microseconds(times.Percentile_ns(0.9999));
    (*report)[name + "max_us"] = Microseconds(static_cast<double>(times.max_ns()));
  };
  add(prefix, statistics.durations);
  add(prefix + "cpu_", statistics.cpu_times);
}

}  // namespace

NodeLoop::NodeLoop(const scene::Scenario& scenario, HapticNode* haptic, bus::Node* node, const Answer* answer)
    : scenario_(scenario),
      haptic_(haptic),
      node_(node),
      answer_(answer),
      changes_(kMaxChangesPerStep),
      tickets_(kMaxChangesPerStep) {
  haptic_->PrepareOutputs(&outputs_);
  for (const scene::Device& device : scenario.devices) limit_names_.push_back(core::StiffnessLimitName(device.role));
  limit_values_.resize(limit_names_.size(), 1.0);  // of stiffness; 1: none
  for (const scene::Device& device : scenario.devices) {
    for (const std::string& name : {core::DampingLimitName(device.role), core::TurnDampingLimitName(device.role)}) {
      if (haptic_->AcceptsParameter({name, 0.0})) limit_names_.push_back(name);
    }
  }
  limit_values_.resize(limit_names_.size(), 0.0);
  for (core::ParameterChange& change : changes_) core::ReserveTexts(&change);
  core::ReserveTexts(&event_);
  lost_.reserve(64);
  for (const char* name : {"cycles", "misses", "step_p50_us", "step_p99_us", "contact_cycles", "contact_p50_us",
                           "pairs_tested", "pairs_in_contact", "points_tested", "pairs_asleep", "pairs_far",
                           "pairs_near", "pairs_cut_short", "stiffness_share"}) {
    figures_.items.push_back({name, 0.0});
  }
}

void NodeLoop::Declare() {
  for (const scene::Device& device : scenario_.devices) {
    devices_.push_back(&node_->ReadLatest<core::DeviceState>(bus::DeviceStateTopic(device.role)));
    if (answer_ == nullptr) {
      reactions_.push_back(&node_->ReadLatest<core::Reaction>(bus::ReactionTopic(device.role)));
    }
    command_writers_.push_back(node_->WriteLatest<core::DeviceCommand>(bus::DeviceCommandTopic(device.role)));
    proxy_writers_.push_back(node_->WriteLatest<core::HapticProxy>(bus::HapticProxyTopic(device.role)));
  }
  if (answer_ == nullptr) physics_ = &node_->ReadLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  for (std::size_t i = 0; i < scenario_.pairs.size(); ++i) {
    const std::string topic = bus::ContactsTopic("haptic_node", scenario_.PairName(i));
    const bool is_mine = scenario_.pairs[i].owner == scene::PairOwner::kHaptic;
    contact_writers_.push_back(is_mine ? node_->WriteLatest<core::ContactSet>(topic)
                                       : bus::LatestWriter<core::ContactSet>{});
  }
  collisions_writer_ = node_->WriteLatest<core::CollisionMatrix>(bus::CollisionsTopic("haptic_node"));
  figures_writer_ = node_->WriteState<bus::Figures>(bus::FiguresTopic("haptic_node"));
  limits_ = &node_->ReadState<bus::Figures>(bus::FiguresTopic("device_bridge"));
  node_->OwnParameters(haptic_->ParameterNames());
}

void NodeLoop::Run(const std::atomic<bool>& stop) {
  Start();
  while (!stop.load(std::memory_order_relaxed)) {
    BeginCycle(WaitForTick(stop));
    EndCycle();
  }
}

void NodeLoop::Start() {
  last_step_begin_ns_ = loop_begin_ns_ = core::MonotonicNow_ns();
  stolen_before_s_ = bus::StolenTime_s();
}

NodeLoop::Tick NodeLoop::WaitForTick(const std::atomic<bool>& stop) {
  std::uint32_t arrived = 0;
  const std::uint32_t all = (1U << devices_.size()) - 1U;
  std::int64_t first_ns = 0;
  // The timer's next tick: 2 ms after the last step while samples arrive, 1 ms while they do not.
  const std::int64_t timer_ns = last_step_begin_ns_ + (timer_steps_ == 0 ? kSilence_ns : core::kTick_ns);
  while (!stop.load(std::memory_order_relaxed)) {
    node_->Wait(first_ns == 0 ? timer_ns : first_ns + kGather_ns);
    for (std::size_t r = 0; r < devices_.size(); ++r) {
      if (!devices_[r]->is_fresh()) continue;
      arrived |= 1U << r;
      if (first_ns != 0) continue;
      const std::int64_t received_ns = devices_[r]->received_ns();
      const std::int64_t sample_ns = devices_[r]->value().sample_ns;
      const bool is_plausible = sample_ns <= received_ns && received_ns - sample_ns < kPlausibleAge_ns;
      first_ns = is_plausible ? sample_ns : received_ns;
    }
    if (first_ns == 0) ReevaluateIfAnswered();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (first_ns != 0 && (arrived == all || now_ns >= first_ns + kGather_ns)) {
      timer_steps_ = 0;
      return {first_ns, false};
    }
    if (first_ns == 0 && now_ns >= timer_ns) {
      ++timer_steps_;
      return {timer_ns, true};
    }
  }
  return {core::MonotonicNow_ns(), true};
}

void NodeLoop::TakeParameters() {
  num_changes_ = 0;
  while (num_changes_ < kMaxChangesPerStep && node_->PollParameter(&changes_[num_changes_], &tickets_[num_changes_])) {
    ++num_changes_;
  }
  num_answers_ = num_changes_;
  TakeLimits();
}

// As changes of a parameter, so that they are recorded with the step. Most of the time all limits of stiffness are
// above 1, and no tool has damping.
void NodeLoop::TakeLimits() {
  if (limits_->version() == limits_version_ || !limits_->has_value()) return;
  limits_version_ = limits_->version();
  for (std::size_t i = 0; i < limit_names_.size() && num_changes_ < kMaxChangesPerStep; ++i) {
    const double* figure = bus::FindFigure(limits_->value(), limit_names_[i]);
    if (figure == nullptr || *figure <= 0.0) continue;  // not measured
    const double limit = i < scenario_.devices.size() ? std::min(*figure, 1.0) : *figure;
    if (limit == limit_values_[i]) continue;
    limit_values_[i] = limit;
    core::ParameterChange& change = changes_[num_changes_++];
    change.name = limit_names_[i];
    change.value = limit;
    change.manner = core::ChangeManner::kAtOnce;
  }
}

void NodeLoop::AnswerParameters() {
  for (std::size_t i = 0; i < num_answers_; ++i) {
    const bool is_accepted = haptic_->AcceptsParameter(changes_[i]);
    node_->AckParameter(tickets_[i], haptic_->cycle(), is_accepted, is_accepted ? no_refusal_ : refusal_);
  }
}

void NodeLoop::RecordSteps(bus::log::StepSink* sink) {
  recorder_ = std::make_unique<replay::StepRecorder<Step>>(sink);
  reevaluation_recorder_ = std::make_unique<replay::StepRecorder<Step>>(sink, kReevaluation);
}

void NodeLoop::Record() {
  is_cycle_recorded_ = true;
  if (recorder_ == nullptr) return;
  step_.pairs_late = outputs_.counters.pairs_late;
  inputs_.budget_points = outputs_.counters.budget_points;  // so that a replay uses the same budget
  recorder_->Record(haptic_->cycle(), inputs_.now_ns, step_);
  inputs_.budget_points = 0;
  RecordReevaluation();
}

void NodeLoop::TakeInputs(std::int64_t now_ns, Inputs* inputs) const {
  inputs->now_ns = now_ns;
  inputs->devices.clear();
  inputs->reactions.clear();
  for (const auto* device : devices_) inputs->devices.push_back(device->value());
  for (const auto* reaction : reactions_) inputs->reactions.push_back(reaction->value());
  if (answer_ != nullptr) inputs->reactions = answer_->reactions;
  inputs->physics = State();
}

const core::PhysicsState* NodeLoop::State() const {
  if (answer_ != nullptr) return answer_->state.header.sequence != 0 ? &answer_->state : nullptr;
  return physics_->has_value() ? &physics_->value() : nullptr;
}

std::int64_t NodeLoop::AnswerReceived_ns(int role, std::uint64_t trace_id) const {
  if (answer_ != nullptr) return answer_->received_ns;
  if (role < 0) return physics_->received_ns();
  const auto* reaction = reactions_[static_cast<std::size_t>(role)];
  const bool is_its = reaction->value().header.through_physics.id == trace_id;
  return is_its ? reaction->received_ns() : physics_->received_ns();
}

// State and reactions arrive one after the other; the last of a tick completes the answer.
void NodeLoop::ReevaluateIfAnswered() {
  const core::PhysicsState* state = State();
  if (state == nullptr || state->tick == taken_tick_) return;
  const std::int64_t start_ns = core::MonotonicNow_ns();
  TakeInputs(start_ns, &reevaluation_.inputs);
  if (!haptic_->IsToReevaluate(reevaluation_.inputs)) return;
  taken_tick_ = state->tick;
  haptic_->Reevaluate(reevaluation_.inputs, &reevaluation_.outputs);
  const std::int64_t end_ns = core::MonotonicNow_ns();
  auto& commands = reevaluation_.outputs.commands;
  for (std::size_t r = 0; r < commands.size(); ++r) {
    if (commands[r].header.through_physics.valid()) SendCommand(r, start_ns, end_ns, &commands[r]);
  }
  reevaluate_durations_.Add(end_ns - start_ns);
  is_reevaluation_to_record_ = true;
  if (is_cycle_recorded_) RecordReevaluation();
}

// After its cycle, as it is repeated.
void NodeLoop::RecordReevaluation() {
  if (!std::exchange(is_reevaluation_to_record_, false) || reevaluation_recorder_ == nullptr) return;
  reevaluation_recorder_->Record(haptic_->cycle(), reevaluation_.inputs.now_ns, reevaluation_);
}

void NodeLoop::SendCommand(std::size_t role, std::int64_t start_ns, std::int64_t end_ns, core::DeviceCommand* command) {
  if (!devices_[role]->has_value()) return;
  Stamp(&command->header, static_cast<int>(role), start_ns, end_ns);
  command_writers_[role].Send(*command);
}

void NodeLoop::BeginCycle(const Tick& tick) {
  TakeParameters();
  const std::int64_t start_ns = core::MonotonicNow_ns();
  is_cycle_recorded_ = false;
  TakeInputs(start_ns, &inputs_);
  taken_tick_ = inputs_.physics != nullptr ? inputs_.physics->tick : 0;
  if (answer_ != nullptr && recorder_ != nullptr && inputs_.physics != nullptr) {
    step_.physics = *inputs_.physics;  // the next answer comes before this cycle is recorded
    inputs_.physics = &step_.physics;
  }
  inputs_.changes = changes_.data();
  inputs_.num_changes = num_changes_;
  const std::int64_t cpu_begin_ns = core::ThreadCpuNow_ns();
  haptic_->Step(inputs_, &outputs_);
  const std::int64_t cpu_ns = core::ThreadCpuNow_ns() - cpu_begin_ns;
  const std::int64_t end_ns = core::MonotonicNow_ns();
  for (std::size_t r = 0; r < outputs_.commands.size(); ++r) SendCommand(r, start_ns, end_ns, &outputs_.commands[r]);
  StampOutputs(start_ns, end_ns);
  Count(tick, start_ns, end_ns, cpu_ns);
  last_step_begin_ns_ = tick.is_timer ? tick.begin_ns : start_ns;
  // Late by more than a period: drop the timer's missed ticks.
  if (end_ns - last_step_begin_ns_ > kSilence_ns) last_step_begin_ns_ = end_ns;
}

void NodeLoop::EndCycle() {
  SendContacts();
  Record();  // after sending, as no other node waits for it
  AnswerParameters();
  ReportLostNodes();
  PublishFigures(core::MonotonicNow_ns());
}

void NodeLoop::StampOutputs(std::int64_t start_ns, std::int64_t end_ns) {
  for (std::size_t i = 0; i < outputs_.contacts.size(); ++i) {
    if (outputs_.contacts_updated[i] == 0) continue;
    const scene::Object& sampled = scenario_.objects[scenario_.pairs[i].sampled];
    const scene::Object& field = scenario_.objects[scenario_.pairs[i].field];
    Stamp(&outputs_.contacts[i].header, std::max(sampled.role, field.role), start_ns, end_ns);
  }
  for (std::size_t r = 0; r < outputs_.proxies.size(); ++r) {
    Stamp(&outputs_.proxies[r].header, static_cast<int>(r), start_ns, end_ns);
  }
}

// Proxies last, because they trigger a physics step, which needs the contacts of the same cycle.
void NodeLoop::SendContacts() {
  for (std::size_t i = 0; i < outputs_.contacts.size(); ++i) {
    if (outputs_.contacts_updated[i] != 0) contact_writers_[i].Send(outputs_.contacts[i]);
  }
  for (std::size_t r = 0; r < outputs_.proxies.size(); ++r) proxy_writers_[r].Send(outputs_.proxies[r]);
  if (outputs_.is_collisions_updated) collisions_writer_.Send(outputs_.collisions);
}

void NodeLoop::Stamp(core::Header* header, int role, std::int64_t start_ns, std::int64_t end_ns) const {
  if (header->direct.valid() && role >= 0) {
    header->direct.Add(core::Stage::kHapticReceive, devices_[static_cast<std::size_t>(role)]->received_ns());
    header->direct.Add(core::Stage::kHapticStart, start_ns);
    header->direct.Add(core::Stage::kHapticSend, end_ns);
  }
  if (header->through_physics.valid()) {
    header->through_physics.Add(core::Stage::kHapticReceive, AnswerReceived_ns(role, header->through_physics.id));
    header->through_physics.Add(core::Stage::kHapticStart, start_ns);
    header->through_physics.Add(core::Stage::kHapticSend, end_ns);
  }
}

void NodeLoop::Count(const Tick& tick, std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) {
  const bool is_miss = end_ns - tick.begin_ns > core::kTick_ns;
  const auto count = [&](CycleStatistics* statistics) {
    statistics->durations.Add(end_ns - start_ns);
    statistics->cpu_times.Add(cpu_ns);
    statistics->misses += is_miss ? 1 : 0;
  };
  count(&all_);
  if (outputs_.is_in_contact) count(&in_contact_);
  const Counters& now = outputs_.counters;
  work_.pairs_cut_short += now.pairs_cut_short;
  work_.pairs_late += now.pairs_late;
  work_.oldest_result_cycles = std::max(work_.oldest_result_cycles, now.oldest_result_cycles);
  work_.pairs_tested += now.pairs_tested;
  work_.spheres_tested += now.spheres_tested;
  work_.points_tested += now.points_tested;
  work_.points_colliding += now.points_colliding;
}

// Prints, and notes for the report, which nodes were lost or found again.
void NodeLoop::ReportLostNodes() {
  while (node_->PollEvent(&event_)) {
    if (event_.name != "node_lost" && event_.name != "node_found") continue;
    if (event_.name == "node_lost" && lost_.size() < lost_.capacity()) lost_.push_back(event_.detail);
    std::printf("%s: %s\n", event_.name == "node_lost" ? "lost" : "found", event_.detail.c_str());
    std::fflush(stdout);
  }
}

void NodeLoop::PublishFigures(std::int64_t now_ns) {
  if (now_ns < next_figures_ns_) return;
  next_figures_ns_ = now_ns + kFiguresPeriod_ns;
  const auto pairs = haptic_->CountPairs();
  const auto in_state = [&pairs](vps::PairState state) {
    return static_cast<double>(pairs[static_cast<std::size_t>(state)]);
  };
  const double values[] = {static_cast<double>(all_.durations.count()),
                           static_cast<double>(all_.misses),
                           Microseconds(all_.durations.p50_ns()),
                           Microseconds(all_.durations.p99_ns()),
                           static_cast<double>(in_contact_.durations.count()),
                           Microseconds(in_contact_.durations.p50_ns()),
                           static_cast<double>(outputs_.counters.pairs_tested),
                           static_cast<double>(outputs_.counters.pairs_in_contact),
                           static_cast<double>(outputs_.counters.points_tested),
                           in_state(vps::PairState::kAsleep),
                           in_state(vps::PairState::kFar),
                           in_state(vps::PairState::kNear),
                           static_cast<double>(work_.pairs_cut_short),
                           haptic_->stiffness_share()};
  for (std::size_t i = 0; i < figures_.items.size(); ++i) figures_.items[i].value = values[i];
  figures_writer_.Set(figures_);
}

bool NodeLoop::WriteReport(const std::filesystem::path& file, bool is_realtime) const {
  nlohmann::json report;
  AddFigures(all_, "", &report);
  AddFigures(in_contact_, "contact_", &report);
  report["reevaluations"] = reevaluate_durations_.count();
  report["reevaluate_p50_us"] = Microseconds(reevaluate_durations_.p50_ns());
  report["reevaluate_p99_us"] = Microseconds(reevaluate_durations_.p99_ns());
  const double ran_s = 1e-9 * static_cast<double>(core::MonotonicNow_ns() - loop_begin_ns_);
  const double processors = std::max(1U, std::thread::hardware_concurrency());
  report["stolen_share"] = (bus::StolenTime_s() - stolen_before_s_) / (processors * ran_s);
  report["is_realtime"] = is_realtime;
  report["work"] = {{"pairs_tested", work_.pairs_tested},
                    {"pairs_cut_short", work_.pairs_cut_short},
                    {"pairs_late", work_.pairs_late},
                    {"oldest_result_cycles", work_.oldest_result_cycles},
                    {"spheres_tested", work_.spheres_tested},
                    {"points_tested", work_.points_tested},
                    {"points_colliding", work_.points_colliding}};
  report["stiffness_share"] = haptic_->stiffness_share();
  report["least_stiffness_share"] = haptic_->least_stiffness_share();
  report["nodes_lost"] = lost_;
  report["clock_bounds_ns"] = bus::ClockBounds(node_->Peers());
  const bus::Counters counters = node_->counters();
  report["bus"] = {{"sent", counters.sent}, {"received", counters.received}, {"dropped", counters.dropped}};
  std::ofstream out(file);
  out << report.dump(2) << "\n";
  return out.good();
}

}  // namespace haptic_node
