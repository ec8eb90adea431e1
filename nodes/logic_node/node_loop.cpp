#include "nodes/logic_node/node_loop.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "core/clock.hpp"

namespace logic_node {
namespace {

// Chosen without a study. Retries last 2 s in total, longer than an owner needs to start; a checkpoint that is 0.1 s
// old loses at most 0.1 s of the procedure's timers.
constexpr std::int64_t kStatusPeriod_ns = 1'000'000'000;  // at least this often, as a sign of life
constexpr std::int64_t kRetry_ns = 200'000'000;
constexpr int kMaxTries = 10;
constexpr std::int64_t kCheckpointPeriod_ns = 100'000'000;

}  // namespace

std::string OwnerOf(const scene::Scenario& scenario, const std::string& parameter) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    if (parameter.starts_with("pair." + scenario.PairName(i) + ".")) return scenario.PairSource(i);
  }
  if (parameter == "force_cap_N" || parameter.starts_with("pair.")) return "haptic_node";
  if (parameter.starts_with("sheet.")) return "physics_node";
  for (const scene::Mechanism& mechanism : scenario.mechanisms) {
    if (parameter.starts_with(mechanism.name + ".")) return "physics_node";
  }
  return {};
}

NodeLoop::NodeLoop(const scene::Scenario& scenario, LogicNode* logic, bus::Node* node)
    : scenario_(scenario), logic_(logic), node_(node) {}

void NodeLoop::Declare() {
  physics_ = &node_->ReadLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  for (const scene::Device& device : scenario_.devices) {
    reactions_.push_back(&node_->ReadLatest<core::Reaction>(bus::ReactionTopic(device.role)));
  }
  status_writer_ = node_->WriteState<core::LogicStatus>(bus::kLogicStatusTopic);
  node_->ReadEvents();
}

void NodeLoop::Run(const std::atomic<bool>& stop, const std::filesystem::path& report) {
  std::int64_t next_ns = core::MonotonicNow_ns();
  bool was_over = false;
  while (!stop.load(std::memory_order_relaxed)) {
    // Sleeps instead of waiting for datagrams: they arrive at 1 kHz, and this loop needs 100 Hz.
    next_ns = std::max(next_ns + kStepPeriod_ns, core::MonotonicNow_ns());
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(next_ns)));
    node_->Poll();
    ReceiveEvents();
    MakeStep();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    ReceiveAcks(now_ns);
    SendChanges(now_ns);
    SaveCheckpoint(now_ns);
    const bool is_over = logic_->status().is_final || logic_->status().is_failed;
    if (is_over && !was_over && !WriteReport(report)) std::fprintf(stderr, "cannot write %s\n", report.c_str());
    was_over = is_over;
  }
}

void NodeLoop::ReceiveEvents() {
  inputs_.events.clear();
  core::Event event;
  while (node_->PollEvent(&event)) {
    if (event.name.starts_with("node_")) {
      std::printf("%s: %s\n", event.name.c_str(), event.detail.c_str());
      std::fflush(stdout);
    }
    inputs_.events.push_back(event);
    TrackNode(event);
  }
  ReportGoneNodes();
}

void NodeLoop::TrackNode(const core::Event& event) {
  if (event.name == "node_lost" || event.name == "node_left") {
    lost_since_ns_.try_emplace(event.detail, core::MonotonicNow_ns());
  } else if (event.name == "node_found" && lost_since_ns_.erase(event.detail) != 0) {
    ResendParameters(event.detail);
  }
}

void NodeLoop::ReportGoneNodes() {
  const std::int64_t now_ns = core::MonotonicNow_ns();
  for (auto lost = lost_since_ns_.begin(); lost != lost_since_ns_.end();) {
    if (now_ns - lost->second < patience_ns_) {
      ++lost;
      continue;
    }
    inputs_.events.push_back({inputs_.now_ns, "logic_node", kNodeGone, lost->first});
    lost = lost_since_ns_.erase(lost);
  }
}

// An owner that was lost may have restarted, so the newest value of each of its parameters is sent again.
void NodeLoop::ResendParameters(const std::string& owner) {
  std::set<std::string> resent;
  for (auto change = changes_.rbegin(); change != changes_.rend(); ++change) {
    const bool is_owned = change->owner == owner || change->owner.empty();
    if (!is_owned || !change->is_accepted || !resent.insert(change->change.name).second) continue;
    change->is_answered = change->is_accepted = false;
    change->tries = 0;
  }
}

std::vector<AppliedChange> NodeLoop::Applied() const {
  std::vector<AppliedChange> applied;
  for (const Change& change : changes_) {
    // Includes changes without an answer so far: a restarted node sends them again.
    if (change.is_accepted || !change.is_answered) {
      applied.push_back({change.owner.empty() ? "*" : change.owner, change.change.name, change.change.value});
    }
  }
  return applied;
}

void NodeLoop::SaveCheckpoint(std::int64_t now_ns) {
  if (checkpoint_.empty() || (now_ns < next_checkpoint_ns_ && !outputs_.is_status_changed)) return;
  next_checkpoint_ns_ = now_ns + kCheckpointPeriod_ns;
  const auto written = WriteCheckpoint({logic_->Save(), Applied()}, checkpoint_);
  if (!written && !is_checkpoint_refused_) {
    std::printf("%s\n", written.error().detail.c_str());
    std::fflush(stdout);
  }
  is_checkpoint_refused_ = !written;
}

core::Result<void> NodeLoop::Resume(const std::filesystem::path& file) {
  const auto checkpoint = ReadCheckpoint(file);
  if (!checkpoint) return tl::unexpected(checkpoint.error());
  if (auto restored = logic_->Restore(checkpoint->state); !restored) return restored;
  for (const AppliedChange& applied : checkpoint->applied) {
    Change entry;
    entry.time_ns = logic_->status().time_ns;
    entry.change = {applied.name, applied.value};
    entry.owner = applied.owner == "*" ? "" : applied.owner;
    changes_.push_back(std::move(entry));
  }
  return {};
}

void NodeLoop::RecordSteps(bus::log::StepSink* sink) {
  recorder_ = std::make_unique<replay::StepRecorder<Step>>(sink);
}

void NodeLoop::MakeStep() {
  // All owners of parameters must be present before the first parameter is set.
  const bool are_owners_there = node_->IsAlive("haptic_node") && node_->IsAlive("physics_node");
  const bool is_running = inputs_.physics != nullptr;
  inputs_.physics = physics_->has_value() && (are_owners_there || is_running) ? &physics_->value() : nullptr;
  inputs_.now_ns = inputs_.physics != nullptr ? inputs_.physics->time_ns : 0;
  inputs_.grasped_objects.clear();
  for (const auto* reaction : reactions_) {
    inputs_.grasped_objects.push_back(reaction->has_value() ? reaction->value().grasped_object : core::kNoObject);
  }
  logic_->Step(inputs_, &outputs_);
  ++num_steps_;
  if (recorder_ != nullptr) recorder_->Record(num_steps_, inputs_.now_ns, step_);

  const std::int64_t now_ns = core::MonotonicNow_ns();
  if (outputs_.is_status_changed || now_ns >= next_status_ns_) {
    if (status_writer_.Set(outputs_.status)) next_status_ns_ = now_ns + kStatusPeriod_ns;
  }
  for (const core::Event& event : outputs_.events) {
    std::printf("%.3f s %s: %s\n", static_cast<double>(event.time_ns) * 1e-9, event.name.c_str(), event.detail.c_str());
    std::fflush(stdout);
    node_->Emit(event);
  }
  for (const core::ParameterChange& change : outputs_.changes) {
    // A newer value of the same parameter replaces one that is not answered yet.
    for (Change& other : changes_) {
      if (other.change.name != change.name || other.is_answered) continue;
      other.is_answered = true;
      other.why = "replaced by a newer value";
    }
    Change entry;
    entry.time_ns = inputs_.now_ns;
    entry.change = change;
    entry.owner = OwnerOf(scenario_, change.name);
    changes_.push_back(std::move(entry));
  }
}

void NodeLoop::SendChanges(std::int64_t now_ns) {
  for (Change& change : changes_) {
    if (change.is_answered || change.request != 0 || now_ns < change.next_try_ns) continue;
    change.request = node_->PostParameter(change.owner, change.change);
    if (change.request == 0) change.next_try_ns = now_ns + kRetry_ns;  // queue full
  }
}

void NodeLoop::ReceiveAcks(std::int64_t now_ns) {
  bus::ParameterAck ack;
  while (node_->PollAck(&ack)) {
    for (Change& change : changes_) {
      if (change.request != ack.request || change.is_answered) continue;
      change.is_accepted = ack.is_accepted;
      change.is_answered = ack.is_accepted || ++change.tries >= kMaxTries;
      change.tick = ack.tick;
      change.why = ack.why;
      change.request = 0;
      change.next_try_ns = now_ns + kRetry_ns;
      if (change.is_answered && !change.is_accepted) {
        const std::string text = change.change.name + ": " + ack.why;
        std::printf("parameter refused: %s\n", text.c_str());
        std::fflush(stdout);
        node_->Emit({inputs_.now_ns, "logic_node", "parameter_refused", text});
      }
    }
  }
}

bool NodeLoop::WriteReport(const std::filesystem::path& file) const {
  const core::LogicStatus& status = logic_->status();
  nlohmann::json report;
  report["completed"] = status.is_final && !status.is_failed;
  if (status.is_failed) report["why"] = status.why;
  report["seconds"] = static_cast<double>(status.time_ns) * 1e-9;
  report["steps"] = nlohmann::json::array();
  for (const StepRecord& step : logic_->steps()) {
    nlohmann::json entry = {{"name", step.name}, {"completed", step.is_completed}, {"seconds", step.seconds}};
    if (!step.is_completed) entry["why"] = step.why;
    report["steps"].push_back(std::move(entry));
  }
  report["changes"] = nlohmann::json::array();
  for (const Change& change : changes_) {
    nlohmann::json entry = {{"time_s", static_cast<double>(change.time_ns) * 1e-9},
                            {"name", change.change.name},
                            {"value", change.change.value},
                            {"owner", change.owner},
                            {"accepted", change.is_accepted}};
    if (change.is_accepted) entry["tick"] = change.tick;
    if (!change.is_accepted) entry["why"] = change.why.empty() ? "no answer" : change.why;
    report["changes"].push_back(std::move(entry));
  }
  const bus::Counters counters = node_->counters();
  report["bus"] = {{"sent", counters.sent}, {"received", counters.received}, {"dropped", counters.dropped}};
  std::ofstream out(file);
  out << report.dump(2) << "\n";
  return out.good();
}

}  // namespace logic_node
