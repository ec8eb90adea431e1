#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"

namespace logic_node::scxml {

// What a chart does to the world.
class Host {
 public:
  virtual ~Host() = default;
  virtual void OnEnter(int state, std::int64_t time_ns) = 0;
  // `transition` is the one that makes the state inactive.
  virtual void OnExit(int state, const Transition& transition, std::int64_t time_ns) = 0;
  // kLog, kSetParameter, kLamp, kHint; `value` is that of the action's expression.
  virtual void OnAction(const Action& action, double value) = 0;
};

// Runs a chart by the algorithm of the SCXML recommendation, appendix D: run to completion, transitions selected in
// document order, conflicts won by the inner source, exits innermost first. Time is given, never read: delays count
// bus time, so a run replays exactly.
class Interpreter {
 public:
  // Both must outlive the interpreter.
  Interpreter(const Chart& chart, Host* host);

  // Enters the initial states. `signals` is the vector that expressions refer to, kept up to date by the caller.
  void Start(std::int64_t now_ns, const std::vector<double>* signals);

  // One step: delayed sends that are due (each at its own time), then `events` in order, then eventless transitions,
  // each to completion.
  void Advance(std::int64_t now_ns, const std::vector<std::string>& events);

  [[nodiscard]] bool IsActive(int state) const { return active_[static_cast<std::size_t>(state)] != 0; }
  [[nodiscard]] bool is_running() const { return is_running_; }
  // The chart did not come to rest within kMaxMicrosteps: it runs in a circle. It is stopped then.
  [[nodiscard]] bool is_circling() const { return is_circling_; }
  [[nodiscard]] std::vector<int> Configuration() const;  // active states in document order
  [[nodiscard]] Environment environment() const { return {signals_, &variables_, &active_}; }
  [[nodiscard]] std::int64_t time_ns() const { return time_ns_; }
  [[nodiscard]] double variable(std::size_t index) const { return variables_[index]; }

  static constexpr int kMaxMicrosteps = 1000;  // per event

 private:
  struct Timer {
    std::int64_t due_ns = 0;
    std::uint64_t order = 0;  // of sending: ties go first come, first served
    std::string event;
    std::string send_id;
  };

  void RunToCompletion();
  void Deliver(const std::string& event);
  void DeliverSent();
  [[nodiscard]] std::vector<int> Select(const std::string* event) const;
  [[nodiscard]] std::vector<int> WithoutConflicts(const std::vector<int>& enabled) const;
  void Microstep(const std::vector<int>& transitions);

  [[nodiscard]] std::vector<int> EffectiveTargets(const Transition& transition) const;
  [[nodiscard]] int Domain(const Transition& transition) const;
  [[nodiscard]] std::vector<int> ExitSet(const Transition& transition) const;
  void Exit(const std::vector<int>& transitions);
  void Enter(const std::vector<int>& transitions);
  void EnterTargets(const std::vector<int>& targets, const std::vector<int>& effective_targets, int domain);
  void AddDescendants(int state);
  void AddAncestors(int state, int ancestor);
  void AddMissingRegions(int parallel);
  void EnterMarked();
  void AnnounceFinal(int state);
  [[nodiscard]] bool IsInFinal(int state) const;

  void Execute(const std::vector<Action>& actions);
  void Execute(const Action& action);

  const Chart& chart_;
  Host* host_;
  const std::vector<double>* signals_ = nullptr;
  std::vector<double> variables_;
  std::vector<char> active_;                 // per state; char, since expressions point into it
  std::map<int, std::vector<int>> history_;  // by history state
  std::deque<std::string> internal_events_;
  std::deque<std::string> sent_events_;
  std::vector<Timer> timers_;
  std::uint64_t num_sent_ = 0;
  std::int64_t time_ns_ = 0;
  bool is_running_ = false;
  bool is_circling_ = false;

  // While entering.
  std::vector<char> to_enter_;
  std::vector<char> by_default_;
  std::map<int, const std::vector<Action>*> history_actions_;  // by the history's parent
};

// SCXML 3.12.1: a descriptor matches an event when its tokens are a prefix of the event's.
bool Matches(const std::string& descriptor, const std::string& event);

}  // namespace logic_node::scxml
