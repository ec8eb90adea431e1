#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/haptic_node/step.hpp"
#include "replay/step_recorder.hpp"

namespace haptic_node {

// Timing of haptic cycles in the report: of all cycles, and of those with at least one pair in contact.
struct CycleStatistics {
  bus::LatencyStats durations;  // computation without sending
  bus::LatencyStats cpu_times;  // of these, the processor time of the step's thread, without other workers'
  std::uint64_t misses = 0;     // steps that ended later than 1 ms after their tick
};

// Connects a HapticNode to the bus: one step per tick of the device bridge.
//
// A tick begins when the first role's sample arrives; the step runs when the samples of all roles have arrived, or 200
// us later. Without a sample for 2 ms a 1 kHz timer takes over, so that proxies continue and forces fade. When physics
// answers between two ticks, the force is reevaluated and sent at once.
//
// In a process with physics_node the answer comes from there: between BeginCycle and EndCycle its owner steps physics,
// fills `answer` and calls ReevaluateIfAnswered.
class NodeLoop {
 public:
  struct Tick {
    std::int64_t begin_ns = 0;  // time of the device sample by this host's clock, or of the timer's tick
    bool is_timer = false;
  };

  // `answer`: null if physics_node is another process.
  NodeLoop(const scene::Scenario& scenario, HapticNode* haptic, bus::Node* node, const Answer* answer = nullptr);

  // Declares the topics that are read and written; call it before bus::Node::Start.
  void Declare();
  // Records every following cycle with all its inputs.
  void RecordSteps(bus::log::StepSink* sink);
  // Runs until `stop` is set.
  void Run(const std::atomic<bool>& stop);

  // Run, in parts.
  void Start();
  Tick WaitForTick(const std::atomic<bool>& stop);
  // One step; sends the commands, which close the force loop.
  void BeginCycle(const Tick& tick);
  void ReevaluateIfAnswered();
  // Sends what others read of the cycle, and does what nobody waits for.
  void EndCycle();
  Outputs* mutable_outputs() { return &outputs_; }

  // Writes the report haptic_node.json; false when it cannot be written.
  bool WriteReport(const std::filesystem::path& file, bool is_realtime) const;

 private:
  void TakeInputs(std::int64_t now_ns, Inputs* inputs) const;
  [[nodiscard]] const core::PhysicsState* State() const;  // null: none yet
  [[nodiscard]] std::int64_t AnswerReceived_ns(int role, std::uint64_t trace_id) const;
  void TakeParameters();
  void TakeLimits();
  void AnswerParameters();
  void Record();
  void RecordReevaluation();
  void SendCommand(std::size_t role, std::int64_t start_ns, std::int64_t end_ns, core::DeviceCommand* command);
  void SendContacts();
  void StampOutputs(std::int64_t start_ns, std::int64_t end_ns);
  void Stamp(core::Header* header, int role, std::int64_t start_ns, std::int64_t end_ns) const;
  void Count(const Tick& tick, std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns);
  void ReportLostNodes();
  void PublishFigures(std::int64_t now_ns);

  scene::Scenario scenario_;
  HapticNode* haptic_;
  bus::Node* node_;
  const Answer* answer_;  // null: read from the bus
  std::vector<bus::LatestReader<core::DeviceState>*> devices_;
  std::vector<bus::LatestReader<core::Reaction>*> reactions_;
  bus::LatestReader<core::PhysicsState>* physics_ = nullptr;
  std::vector<bus::LatestWriter<core::DeviceCommand>> command_writers_;
  std::vector<bus::LatestWriter<core::HapticProxy>> proxy_writers_;
  std::vector<bus::LatestWriter<core::ContactSet>> contact_writers_;
  bus::LatestWriter<core::CollisionMatrix> collisions_writer_;
  bus::StateWriter<bus::Figures> figures_writer_;
  bus::Figures figures_;

  Step step_;
  Inputs& inputs_ = step_.inputs;
  Outputs& outputs_ = step_.outputs;
  std::unique_ptr<replay::StepRecorder<Step>> recorder_;  // null: steps are not recorded
  Step reevaluation_;
  std::unique_ptr<replay::StepRecorder<Step>> reevaluation_recorder_;
  bool is_cycle_recorded_ = true;
  bool is_reevaluation_to_record_ = false;
  std::uint64_t taken_tick_ = 0;            // of physics, by the last step or reevaluation
  bus::LatencyStats reevaluate_durations_;  // without sending
  std::vector<core::ParameterChange> changes_;
  std::vector<std::uint64_t> tickets_;
  const std::string no_refusal_;
  const std::string refusal_ = "haptic_node refuses it: the value must be 0 or more, without ramp or hold";
  std::size_t num_changes_ = 0;
  std::size_t num_answers_ = 0;                       // of them, those that somebody waits for: the first ones
  bus::StateReader<bus::Figures>* limits_ = nullptr;  // of device_bridge
  std::uint64_t limits_version_ = 0;
  std::vector<std::string> limit_names_;  // stiffness per role, then damping of those that have some
  std::vector<double> limit_values_;      // as passed on
  core::Event event_;
  std::vector<std::string> lost_;  // names of lost nodes
  std::int64_t last_step_begin_ns_ = 0;
  std::int64_t next_figures_ns_ = 0;
  std::uint64_t timer_steps_ = 0;
  Counters work_;  // sums over all cycles
  CycleStatistics all_;
  CycleStatistics in_contact_;
  std::int64_t loop_begin_ns_ = 0;
  double stolen_before_s_ = 0.0;
};

}  // namespace haptic_node
