#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "nodes/physics_node/sheet_outlet.hpp"
#include "nodes/physics_node/snapshot_writer.hpp"
#include "nodes/physics_node/step.hpp"
#include "replay/step_recorder.hpp"

namespace physics_node {

// Schedules ticks so that simulated time follows real time while each haptic cycle gets its tick at once.
//
// A tick is owed when its time has come but it has not been made. A new haptic cycle makes one tick, up to kMaxCatchUp
// if more are owed, and none if physics is kMaxAhead ahead already (cycles in a burst). Without cycles, the timer makes
// ticks once kPatience are owed. After a stall of more than kStall ticks the owed time is dropped.
//
// The numbers of ticks are free choices: small ones bound the jitter and the length of a catch-up, larger ones bear
// more bursts; 50 ms is below the 60 ms after which the device's watchdog drops the force.
class TickPlan {
 public:
  static constexpr std::int64_t kMaxAhead = 2;
  static constexpr std::int64_t kPatience = 2;
  static constexpr std::int64_t kMaxCatchUp = 4;
  static constexpr std::int64_t kStall = 50;

  explicit TickPlan(std::int64_t start_ns) : epoch_ns_(start_ns) {}

  [[nodiscard]] int Plan(std::int64_t now_ns, bool is_new_cycle);
  // Time at which the timer makes a tick if no cycle comes.
  [[nodiscard]] std::int64_t deadline_ns() const { return epoch_ns_ + (made_ + kPatience) * core::kTick_ns; }
  [[nodiscard]] std::uint64_t timer_ticks() const { return timer_ticks_; }
  [[nodiscard]] std::uint64_t dropped_ticks() const { return dropped_ticks_; }

 private:
  std::int64_t epoch_ns_;
  std::int64_t made_ = 0;
  std::uint64_t timer_ticks_ = 0;
  std::uint64_t dropped_ticks_ = 0;
};

// Connects a PhysicsNode to the bus: makes a tick when the proxies of all roles of a new haptic cycle have arrived
// (contacts are sent before them), or by the timer. In a process with haptic_node, it makes them when its owner has
// filled `cycle` and calls StepAfterCycle.
class NodeLoop {
 public:
  // `cycle`: null if haptic_node is another process.
  NodeLoop(const scene::Scenario& scenario, PhysicsNode* physics, bus::Node* node, Cycle* cycle = nullptr);

  void Declare();  // call it before bus::Node::Start
  // Restores the contact sets of a snapshot that PhysicsNode::Restore has read.
  void Restore(Snapshot* snapshot);
  // Writes a checkpoint to `file` every `period_ns` of simulated time, unless the previous one is still being written.
  void KeepCheckpoints(const std::filesystem::path& file, std::int64_t period_ns);
  // Records every following tick with all its inputs.
  void RecordSteps(bus::log::StepSink* sink);
  void Run(const std::atomic<bool>& stop);

  // Run, in parts, for a process with haptic_node.
  void Start();
  // Makes the ticks that are due with the new cycle; false: none.
  bool StepAfterCycle();
  // Sends the last tick, and does what nobody waits for.
  void EndTicks();
  Outputs* mutable_outputs() { return &outputs_; }

  bool WriteReport(const std::filesystem::path& file, bool is_realtime) const;

 private:
  // Waits until ticks are due; returns their number.
  int WaitForTicks(const std::atomic<bool>& stop);
  void TakeFresh();
  bool IsNewCycle() const;
  void TakeParameters();
  void AnswerParameters();
  void MakeTicks(int num_ticks);
  void Send();
  void Record();
  void Checkpoint();
  void Fill(Snapshot* snapshot);
  void ReportLostNodes();
  void PublishFigures(std::int64_t now_ns);

  scene::Scenario scenario_;
  PhysicsNode* physics_;
  bus::Node* node_;
  Cycle read_cycle_;  // from the bus
  Cycle* cycle_;      // that, or what haptic_node gives within the process
  std::vector<bus::LatestReader<core::HapticProxy>*> proxies_;
  std::vector<bus::LatestReader<core::ContactSet>*> contacts_;  // null where none is read
  std::vector<bus::LatestWriter<core::ContactSet>> own_contact_writers_;
  bus::LatestWriter<core::CollisionMatrix> collisions_writer_;
  core::CollisionMatrix collisions_;
  std::uint64_t next_collisions_ = 0;  // tick
  bus::LatestWriter<core::PhysicsState> state_writer_;
  SheetOutlet sheets_;
  std::vector<bus::LatestWriter<core::Reaction>> reaction_writers_;
  bus::StateWriter<bus::Figures> figures_writer_;
  core::Event event_;
  std::vector<std::string> lost_;  // names of lost nodes
  bus::Figures figures_;

  Step step_;
  Inputs& inputs_ = step_.inputs;
  Outputs& outputs_ = step_.outputs;
  std::unique_ptr<replay::StepRecorder<Step>> recorder_;  // null: steps are not recorded
  std::uint64_t num_late_ = 0;                            // late steps of sheets up to the last tick
  std::vector<core::ParameterChange> changes_;
  std::vector<std::uint64_t> tickets_;
  const std::string no_refusal_;
  const std::string refusal_ =
      "physics_node refuses it: the value must be finite, and 0 or more unless it is a motor's speed; only values of "
      "mechanisms can be ramped or held";
  core::FixedVector<ChangeOutcome, kMaxChangesPerTick> outcomes_;
  std::size_t num_changes_ = 0;
  std::uint64_t first_tick_ = 0;              // tick at the start of which the newest changes were applied
  std::vector<std::uint64_t> stepped_cycle_;  // per role: cycle of the last tick
  TickPlan plan_{0};
  std::int64_t next_figures_ns_ = 0;
  bus::LatencyStats durations_;
  std::unique_ptr<SnapshotWriter> writer_;  // null: no checkpoints
  std::uint64_t checkpoint_ticks_ = 0;      // interval
  std::uint64_t next_checkpoint_ = 0;       // tick
  std::uint64_t checkpoints_skipped_ = 0;   // because the previous one was still being written
  bus::LatencyStats checkpoint_durations_;  // of the step thread's part
};

}  // namespace physics_node
