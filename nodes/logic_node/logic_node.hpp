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

constexpr std::int64_t kStepPeriod_ns = 10'000'000;  // 100 Hz of bus time

// How a procedure step went, for the run's report.
struct StepRecord {
  std::string name;
  bool is_completed = false;
  bool is_entered = false;
  double seconds = 0.0;  // of bus time, all visits together
  std::string why;       // when not completed
};

// Event of the node's loop: a node was lost or left, and has not come back in time. A procedure that needs it fails.
constexpr const char* kNodeGone = "node_gone";

// Runs the scenario's procedure on bus time: sees the published state, shows step, hint and lamps, and changes
// parameters. The chart begins with the first physics state that arrives, so that no condition is judged on values
// nobody sent. Events reach the chart as "name.detail" (or "name" when the detail holds blanks), e.g. "engage.latch_a".
class LogicNode final : private scxml::Host {
 public:
  // The error lists every diagnostic, a line each.
  static core::Result<std::unique_ptr<LogicNode>> Create(const scene::Scenario& scenario);

  void Step(const Inputs& inputs, Outputs* outputs);

  // Between steps: all that the next step depends on, for a node of the same scenario to go on from. A failed Restore
  // leaves a node that is of no use.
  [[nodiscard]] std::vector<std::uint8_t> Save() const;
  core::Result<void> Restore(const std::vector<std::uint8_t>& state);

  // Steps in document order, up to date after each Step.
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
  void HearOfNodes(const Inputs& inputs);
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
  std::int64_t last_lost_ns_ = 0;  // bus time when a needed one was last among them
  std::string hint_;
  core::LogicStatus status_;
  Outputs* outputs_ = nullptr;  // of the current Step
  bool is_started_ = false;
  int region_ = -1;
};

// Event name for the chart, see LogicNode.
std::string EventName(const core::Event& event);

}  // namespace logic_node
