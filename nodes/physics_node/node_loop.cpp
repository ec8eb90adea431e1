#include "nodes/physics_node/node_loop.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "bus/membership/clock_bounds.hpp"
#include "core/clock.hpp"
#include "core/messages/reserve_texts.hpp"

namespace physics_node {
namespace {

constexpr std::int64_t kFiguresPeriod_ns = 500'000'000;
constexpr std::uint64_t kCollisionsPeriod_ticks = 16;  // of the collision matrix, as haptic_node's

}  // namespace

int TickPlan::Plan(std::int64_t now_ns, bool is_new_cycle) {
  std::int64_t owed = (now_ns - epoch_ns_) / core::kTick_ns - made_;
  if (owed > kStall) {
    dropped_ticks_ += static_cast<std::uint64_t>(owed - 1);
    epoch_ns_ += (owed - 1) * core::kTick_ns;
    owed = 1;
  }
  std::int64_t count = 0;
  if (is_new_cycle) {
    count = owed <= -kMaxAhead ? 0 : std::clamp<std::int64_t>(owed, 1, kMaxCatchUp);
  } else if (owed >= kPatience) {
    // Leaves one tick for the cycle that may still come.
    count = std::min(owed - kPatience + 1, kMaxCatchUp);
    timer_ticks_ += static_cast<std::uint64_t>(count);
  }
  made_ += count;
  return static_cast<int>(count);
}

NodeLoop::NodeLoop(const scene::Scenario& scenario, PhysicsNode* physics, bus::Node* node, Cycle* cycle)
    : scenario_(scenario),
      physics_(physics),
      node_(node),
      cycle_(cycle != nullptr ? cycle : &read_cycle_),
      changes_(kMaxChangesPerTick),
      tickets_(kMaxChangesPerTick),
      stepped_cycle_(scenario.devices.size()) {
  cycle_->contacts.resize(scenario.pairs.size());
  for (core::ParameterChange& change : changes_) core::ReserveTexts(&change);
  core::ReserveTexts(&event_);
  for (const char* name : {"ticks", "step_p50_us", "step_p99_us", "impulse_balance", "timer_ticks", "dropped_ticks"}) {
    figures_.items.push_back({name, 0.0});
  }
}

void NodeLoop::Declare() {
  lost_.reserve(64);
  for (const scene::Device& device : scenario_.devices) {
    if (cycle_ == &read_cycle_) {
      proxies_.push_back(&node_->ReadLatest<core::HapticProxy>(bus::HapticProxyTopic(device.role)));
    }
    reaction_writers_.push_back(node_->WriteLatest<core::Reaction>(bus::ReactionTopic(device.role)));
  }
  for (std::size_t i = 0; i < scenario_.pairs.size(); ++i) {
    const scene::Pair& pair = scenario_.pairs[i];
    const bool is_read = cycle_ == &read_cycle_ && pair.owner == scene::PairOwner::kHaptic &&
                         (scenario_.objects[pair.sampled].owner == scene::Owner::kPhysics ||
                          scenario_.objects[pair.field].owner == scene::Owner::kPhysics);
    const std::string topic = bus::ContactsTopic(scenario_.PairSource(i), scenario_.PairName(i));
    contacts_.push_back(is_read ? &node_->ReadLatest<core::ContactSet>(topic) : nullptr);
    if (pair.owner != scene::PairOwner::kPhysics) continue;
    own_contact_writers_.push_back(node_->WriteLatest<core::ContactSet>(topic));
  }
  state_writer_ = node_->WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  if (physics_->own_contacts().num_pairs() > 0) {
    collisions_writer_ = node_->WriteLatest<core::CollisionMatrix>(bus::CollisionsTopic("physics_node"));
  }
  sheets_.Declare(scenario_, physics_->sheets(), node_);
  figures_writer_ = node_->WriteState<bus::Figures>(bus::FiguresTopic("physics_node"));
  node_->OwnParameters(physics_->ParameterNames());
}

void NodeLoop::Restore(Snapshot* snapshot) {
  snapshot->inputs.BeginReading();
  for (core::ContactSet& set : cycle_->contacts) snapshot->inputs.Exchange(&set);
}

void NodeLoop::KeepCheckpoints(const std::filesystem::path& file, std::int64_t period_ns) {
  writer_ = std::make_unique<SnapshotWriter>(file, physics_->content_digest());
  checkpoint_ticks_ = static_cast<std::uint64_t>(std::max(period_ns, core::kTick_ns) / core::kTick_ns);
  next_checkpoint_ = physics_->tick() + checkpoint_ticks_;
  Fill(writer_->Begin());  // allocates here rather than in the step thread
}

void NodeLoop::Fill(Snapshot* snapshot) {
  physics_->Save(snapshot);
  snapshot->inputs.BeginWriting();
  for (core::ContactSet& set : cycle_->contacts) snapshot->inputs.Exchange(&set);
}

void NodeLoop::Checkpoint() {
  if (writer_ == nullptr || physics_->tick() < next_checkpoint_) return;
  // Prefer a tick without a sheet step in progress, for at most one more period.
  if (!physics_->is_quiet() && physics_->tick() < next_checkpoint_ + checkpoint_ticks_) return;
  next_checkpoint_ = physics_->tick() + checkpoint_ticks_;
  Snapshot* snapshot = writer_->Begin();
  if (snapshot == nullptr) {
    ++checkpoints_skipped_;
    return;
  }
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  Fill(snapshot);
  writer_->Commit();
  checkpoint_durations_.Add(core::MonotonicNow_ns() - begin_ns);
}

void NodeLoop::Run(const std::atomic<bool>& stop) {
  Start();
  while (!stop.load(std::memory_order_relaxed)) {
    const int num_ticks = WaitForTicks(stop);
    if (num_ticks == 0) continue;
    MakeTicks(num_ticks);
    EndTicks();
  }
}

void NodeLoop::Start() {
  plan_ = TickPlan(core::MonotonicNow_ns());
}

bool NodeLoop::StepAfterCycle() {
  const int num_ticks = plan_.Plan(core::MonotonicNow_ns(), true);
  if (num_ticks > 0) MakeTicks(num_ticks);
  return num_ticks > 0;
}

void NodeLoop::EndTicks() {
  // In a process with haptic_node nothing is read, but a step thread that never waits counts as stalled.
  if (cycle_ != &read_cycle_) node_->Poll();
  Send();
  Record();  // after sending, as no other node waits for it
  AnswerParameters();
  Checkpoint();
  ReportLostNodes();
  PublishFigures(core::MonotonicNow_ns());
}

int NodeLoop::WaitForTicks(const std::atomic<bool>& stop) {
  while (!stop.load(std::memory_order_relaxed)) {
    node_->Wait(plan_.deadline_ns());
    TakeFresh();
    const bool is_new_cycle = IsNewCycle();
    const int num_ticks = plan_.Plan(core::MonotonicNow_ns(), is_new_cycle);
    if (is_new_cycle) {
      for (std::size_t r = 0; r < proxies_.size(); ++r) stepped_cycle_[r] = proxies_[r]->value().cycle;
    }
    cycle_->proxies.clear();
    for (const auto* reader : proxies_) cycle_->proxies.push_back(reader->value());
    if (num_ticks > 0) return num_ticks;
  }
  return 0;
}

void NodeLoop::TakeFresh() {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (contacts_[i] != nullptr && contacts_[i]->is_fresh()) cycle_->contacts[i] = contacts_[i]->value();
  }
}

bool NodeLoop::IsNewCycle() const {
  if (proxies_.empty()) return false;
  for (std::size_t r = 0; r < proxies_.size(); ++r) {
    if (!proxies_[r]->has_value() || proxies_[r]->value().cycle == stepped_cycle_[r]) return false;
  }
  return true;
}

void NodeLoop::TakeParameters() {
  num_changes_ = 0;
  while (num_changes_ < kMaxChangesPerTick && node_->PollParameter(&changes_[num_changes_], &tickets_[num_changes_])) {
    ++num_changes_;
  }
}

void NodeLoop::AnswerParameters() {
  for (std::size_t i = 0; i < num_changes_; ++i) {
    const ChangeOutcome& outcome = outcomes_[i];
    node_->AckParameter(tickets_[i], first_tick_, outcome.is_accepted, outcome.is_accepted ? no_refusal_ : refusal_,
                        outcome.injected_J, outcome.is_pending);
  }
}

void NodeLoop::RecordSteps(bus::log::StepSink* sink) {
  recorder_ = std::make_unique<replay::StepRecorder<Step>>(sink);
}

void NodeLoop::Record() {
  const std::uint64_t num_late = physics_->sheets().num_late();
  step_.is_sheet_late = num_late != std::exchange(num_late_, num_late);
  if (recorder_ != nullptr) recorder_->Record(physics_->tick(), inputs_.now_ns, step_);
}

void NodeLoop::MakeTicks(int num_ticks) {
  TakeParameters();
  const std::int64_t start_ns = core::MonotonicNow_ns();
  inputs_.now_ns = start_ns;
  inputs_.proxies = cycle_->proxies;
  for (std::size_t r = 0; r < inputs_.proxies.size(); ++r) {
    core::Trace& trace = inputs_.proxies[r].header.direct;
    trace.Add(core::Stage::kPhysicsReceive, proxies_.empty() ? cycle_->received_ns : proxies_[r]->received_ns());
    trace.Add(core::Stage::kPhysicsStart, start_ns);
  }
  inputs_.contacts = cycle_->contacts.data();
  inputs_.num_contacts = cycle_->contacts.size();
  inputs_.changes = changes_.data();
  inputs_.num_changes = num_changes_;
  for (int i = 0; i < num_ticks; ++i) {
    if (i > 0) {
      Record();  // the previous tick, whose results are not sent
      inputs_.num_changes = 0;
    }
    physics_->Step(inputs_, &outputs_);
    if (i == 0) {
      first_tick_ = physics_->tick();
      outcomes_ = outputs_.outcomes;
    }
    for (const core::Event& event : outputs_.events) node_->Emit(event);
  }
  const std::int64_t end_ns = core::MonotonicNow_ns();
  durations_.Add((end_ns - start_ns) / num_ticks);

  const auto stamp = [end_ns](core::Header* header) {
    header->direct.Add(core::Stage::kPhysicsSend, end_ns);
    header->through_physics.Add(core::Stage::kPhysicsSend, end_ns);
  };
  for (core::Reaction& reaction : outputs_.reactions) stamp(&reaction.header);
  stamp(&outputs_.state.header);
}

// Reactions first, as they close the force loop.
void NodeLoop::Send() {
  for (std::size_t r = 0; r < outputs_.reactions.size(); ++r) reaction_writers_[r].Send(outputs_.reactions[r]);
  state_writer_.Send(outputs_.state);
  sheets_.Send(physics_->sheets(), physics_->tick());
  OwnContacts& own = physics_->own_contacts();
  for (std::size_t i = 0; i < own.num_pairs(); ++i) {
    if (own.is_published(i)) own_contact_writers_[i].Send(own.set(i));
  }
  if (own.num_pairs() == 0 || physics_->tick() < next_collisions_) return;
  next_collisions_ = physics_->tick() + kCollisionsPeriod_ticks;
  physics_->FillCollisions(&collisions_);
  collisions_writer_.Send(collisions_);
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
  const double values[] = {static_cast<double>(physics_->tick()),
                           durations_.p50_ns() * 1e-3,
                           durations_.p99_ns() * 1e-3,
                           physics_->impulse_balance().relative(),
                           static_cast<double>(plan_.timer_ticks()),
                           static_cast<double>(plan_.dropped_ticks())};
  for (std::size_t i = 0; i < figures_.items.size(); ++i) figures_.items[i].value = values[i];
  figures_writer_.Set(figures_);
}

bool NodeLoop::WriteReport(const std::filesystem::path& file, bool is_realtime) const {
  const physics::ImpulseBalance balance = physics_->impulse_balance();
  nlohmann::json report;
  report["ticks"] = physics_->tick();
  report["timer_ticks"] = plan_.timer_ticks();
  report["sheet_steps"] = physics_->sheets().num_steps();
  report["sheet_steps_late"] = physics_->sheets().num_late();
  report["dropped_ticks"] = plan_.dropped_ticks();
  report["step_p50_us"] = durations_.p50_ns() * 1e-3;
  report["step_p99_us"] = durations_.p99_ns() * 1e-3;
  report["step_max_us"] = static_cast<double>(durations_.max_ns()) * 1e-3;
  report["is_realtime"] = is_realtime;
  report["impulse_balance"] = balance.relative();
  report["impulses"] = {{"linear_residual_Ns", balance.linear_residual_Ns},
                        {"linear_magnitude_Ns", balance.linear_magnitude_Ns},
                        {"angular_residual_Nms", balance.angular_residual_Nms},
                        {"angular_magnitude_Nms", balance.angular_magnitude_Nms}};
  if (writer_ != nullptr) {
    report["checkpoints"] = {{"written", writer_->num_written()},
                             {"failed", writer_->num_failed()},
                             {"skipped", checkpoints_skipped_},
                             {"save_p50_us", checkpoint_durations_.p50_ns() * 1e-3},
                             {"save_max_us", static_cast<double>(checkpoint_durations_.max_ns()) * 1e-3}};
  }
  const bus::Counters counters = node_->counters();
  report["nodes_lost"] = lost_;
  report["clock_bounds_ns"] = bus::ClockBounds(node_->Peers());
  report["bus"] = {{"sent", counters.sent}, {"received", counters.received}, {"dropped", counters.dropped}};
  std::ofstream out(file);
  out << report.dump(2) << "\n";
  return out.good();
}

}  // namespace physics_node
