#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "nodes/logic_node/ports.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "nodes/logic_node/scxml/interpreter.hpp"
#include "nodes/logic_node/signals.hpp"
#include "scene/scenario.hpp"

namespace logic_node {

constexpr std::int64_t kStepPeriod_ns = 10'000'000;  // 100 Hz of bus time; chosen: short for people, cheap for the CPU

// Outcome of a procedure step, for the run's report.
struct StepRecord {
  std::string name;
  bool is_completed = false;
  bool is_entered = false;
  double seconds = 0.0;  // bus time, summed over all visits
  std::string why;       // when not completed
};

// Event of the node's loop: a node was lost or left and has not returned in time. A procedure that needs it fails.
constexpr const char* kNodeGone = "node_gone";

// Runs the scenario's procedure on bus time: reads the published state, publishes step, hint and lamps, and changes
// parameters. The chart starts with the first physics state that arrives, so no condition is evaluated on default
// values. Events reach the chart as "name.detail", blanks replaced by dots, e.g. "snap_engaged.latch_a".
class LogicNode final : private scxml::Host {
 public:
  // Error: kInvalidInput, with one line per diagnostic of the procedure.
  static core::Result<std::unique_ptr<LogicNode>> Create(const scene::Scenario& scenario);

  void Step(const Inputs& inputs, Outputs* outputs);

  // The complete state between steps, from which a node of the same scenario continues. After a failed Restore
  // (kInvalidInput) the node must not be used.
  [[nodiscard]] std::vector<std::uint8_t> Save() const;
  core::Result<void> Restore(const std::vector<std::uint8_t>& state);

  // Steps in document order, as of the last Step.
  [[nodiscard]] std::vector<StepRecord> steps() const;
  [[nodiscard]] const core::LogicStatus& status() const { return status_; }

 private:
  struct StepTimes {
    int state = 0;
    StepRecord record;
    std::int64_t entered_ns = 0;
    bool is_active = false;
  };

  explicit LogicNode(const scene::Scenario& scenario);

  void OnEnter(int state, std::int64_t time_ns) override;
  void OnExit(int state, const scxml::Transition& transition, std::int64_t time_ns) override;
  void OnAction(const scxml::Action& action, double value) override;

  template <class V>
  void VisitState(V& v);
  void UpdateLostNodes(const Inputs& inputs);
  void CheckProgress(const Inputs& inputs);
  void Fail(const std::string& why);
  void UpdateStatus(const Inputs& inputs);
  StepTimes* FindStep(int state);
  StepTimes* ActiveStep();
  [[nodiscard]] std::string DescribeWait(int step) const;

  scene::Scenario scenario_;
  Signals signals_;
  scxml::Chart chart_;
  std::unique_ptr<scxml::Interpreter> interpreter_;
  std::vector<StepTimes> steps_;
  std::vector<std::string> lost_nodes_;
  std::int64_t last_lost_ns_ = 0;  // last bus time at which a needed node was lost
  std::string hint_;
  core::LogicStatus status_;
  Outputs* outputs_ = nullptr;  // of the current Step
  bool is_started_ = false;
  int region_ = -1;
};

// Name of an event in the chart, see LogicNode.
std::string EventName(const core::Event& event);

}  // namespace logic_node
