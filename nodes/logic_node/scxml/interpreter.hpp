#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "replay/fields.hpp"

namespace logic_node::scxml {

// Receives the effects of a chart.
class Host {
 public:
  virtual ~Host() = default;
  virtual void OnEnter(int state, std::int64_t time_ns) = 0;
  // `transition` is the one that makes the state inactive.
  virtual void OnExit(int state, const Transition& transition, std::int64_t time_ns) = 0;
  // kLog, kSetParameter, kLamp, kHint; `value` is that of the action's expression.
  virtual void OnAction(const Action& action, double value) = 0;
};

// Runs a chart by the algorithm of the W3C SCXML recommendation, appendix D: run to completion, transitions selected in
// document order, the inner source preferred in conflicts, exits innermost first. Time is an argument, never read from
// a clock: delays count bus time, so a run replays exactly.
class Interpreter {
 public:
  // Both must outlive the interpreter.
  Interpreter(const Chart& chart, Host* host);

  // Enters the initial states. Expressions read `signals`, which the caller updates.
  void Start(std::int64_t now_ns, const std::vector<double>* signals);

  // One step: delayed sends that are due (each at its own time), then `events` in order, then eventless transitions,
  // each run to completion.
  void Advance(std::int64_t now_ns, const std::vector<std::string>& events);

  [[nodiscard]] bool IsActive(int state) const { return active_[static_cast<std::size_t>(state)] != 0; }
  [[nodiscard]] bool is_running() const { return is_running_; }
  // The chart did not come to rest within kMaxMicrosteps, so it was stopped: its transitions trigger each other
  // endlessly.
  [[nodiscard]] bool is_circling() const { return is_circling_; }
  [[nodiscard]] std::vector<int> Configuration() const;  // active states in document order
  [[nodiscard]] Environment environment() const { return {signals_, &variables_, &active_}; }
  [[nodiscard]] std::int64_t time_ns() const { return time_ns_; }
  [[nodiscard]] double variable(std::size_t index) const { return variables_[index]; }

  static constexpr int kMaxMicrosteps = 1000;  // per event; far above the number of states of any chart in use

  // The complete state between steps (replay/fields.hpp), for an interpreter of the same chart. After reading it, call
  // set_signals.
  template <class V>
  void VisitState(V& v);
  [[nodiscard]] bool FitsChart() const {
    return active_.size() == chart_.states.size() && (!is_running_ || variables_.size() == chart_.variables.size());
  }
  void set_signals(const std::vector<double>* signals) { signals_ = signals; }

 private:
  struct Timer {
    std::int64_t due_ns = 0;
    std::uint64_t order = 0;  // of sending; decides among timers with equal due time
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
  std::vector<char> active_;                 // per state; char rather than bool, as expressions hold pointers to it
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

template <class V>
void Interpreter::VisitState(V& v) {
  const auto texts = [&v](const char* name, std::deque<std::string>* events) {
    std::vector<std::string> list(events->begin(), events->end());
    replay::Items(v, name, list);
    events->assign(list.begin(), list.end());
  };
  replay::Items(v, "variables", variables_);
  replay::Items(v, "active", active_);
  std::vector<std::pair<int, std::vector<int>>> history(history_.begin(), history_.end());
  history.resize(v.Count("history", history.size()));
  for (auto& [state, states] : history) {
    v.Value("history.state", state);
    replay::Items(v, "history.states", states);
  }
  history_ = {history.begin(), history.end()};
  texts("internal_events", &internal_events_);
  texts("sent_events", &sent_events_);
  timers_.resize(v.Count("timers", timers_.size()));
  for (Timer& timer : timers_) {
    v.Value("timers.due_ns", timer.due_ns);
    v.Value("timers.order", timer.order);
    v.Text("timers.event", timer.event);
    v.Text("timers.send_id", timer.send_id);
  }
  v.Value("num_sent", num_sent_);
  v.Value("time_ns", time_ns_);
  v.Value("is_running", is_running_);
  v.Value("is_circling", is_circling_);
}

// SCXML 3.12.1: a descriptor matches an event if its dot-separated tokens are a prefix of the event's.
bool Matches(const std::string& descriptor, const std::string& event);

}  // namespace logic_node::scxml
