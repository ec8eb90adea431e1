#include "nodes/logic_node/scxml/interpreter.hpp"

#include <algorithm>
#include <cmath>

namespace logic_node::scxml {

bool Matches(const std::string& descriptor, const std::string& event) {
  if (descriptor == "*" || descriptor == event) return true;
  return event.size() > descriptor.size() && event.compare(0, descriptor.size(), descriptor) == 0 &&
         event[descriptor.size()] == '.';
}

Interpreter::Interpreter(const Chart& chart, Host* host)
    : chart_(chart), host_(host), active_(chart.states.size(), 0), to_enter_(active_), by_default_(active_) {}

void Interpreter::Start(std::int64_t now_ns, const std::vector<double>* signals) {
  signals_ = signals;
  time_ns_ = now_ns;
  is_running_ = true;
  variables_.assign(chart_.variables.size(), 0.0);
  for (std::size_t i = 0; i < variables_.size(); ++i)
    variables_[i] = chart_.variables[i].initial.Evaluate(environment());
  active_[0] = 1;
  const std::vector<int>& targets = chart_.states[0].initial;
  EnterTargets(targets, targets, 0);
  Execute(chart_.states[0].initial_actions);
  EnterMarked();
  RunToCompletion();
  DeliverSent();
}

void Interpreter::Advance(std::int64_t now_ns, const std::vector<std::string>& events) {
  while (is_running_) {
    const auto first = std::min_element(timers_.begin(), timers_.end(), [](const Timer& a, const Timer& b) {
      return a.due_ns != b.due_ns ? a.due_ns < b.due_ns : a.order < b.order;
    });
    if (first == timers_.end() || first->due_ns > now_ns) break;
    // The event is processed at its due time, so that delays add up exactly for any step width.
    time_ns_ = std::max(time_ns_, first->due_ns);
    const std::string event = first->event;
    timers_.erase(first);
    Deliver(event);
  }
  time_ns_ = std::max(time_ns_, now_ns);
  for (const std::string& event : events) {
    if (is_running_) Deliver(event);
  }
  if (is_running_) RunToCompletion();
  DeliverSent();
}

void Interpreter::Deliver(const std::string& event) {
  const std::vector<int> transitions = Select(&event);
  if (!transitions.empty()) Microstep(transitions);
  RunToCompletion();
  DeliverSent();
}

// Events sent without delay are external: they are processed after all internal ones.
void Interpreter::DeliverSent() {
  for (int count = 0; is_running_ && !sent_events_.empty(); ++count) {
    if (count >= kMaxMicrosteps) {
      is_circling_ = true;
      is_running_ = false;
      return;
    }
    const std::string event = sent_events_.front();
    sent_events_.pop_front();
    const std::vector<int> transitions = Select(&event);
    if (!transitions.empty()) Microstep(transitions);
    RunToCompletion();
  }
}

void Interpreter::RunToCompletion() {
  for (int count = 0; is_running_; ++count) {
    if (count >= kMaxMicrosteps) {
      is_circling_ = true;
      is_running_ = false;
      return;
    }
    std::vector<int> transitions = Select(nullptr);
    if (transitions.empty()) {
      if (internal_events_.empty()) return;
      const std::string event = internal_events_.front();
      internal_events_.pop_front();
      transitions = Select(&event);
    }
    if (!transitions.empty()) Microstep(transitions);
  }
}

std::vector<int> Interpreter::Configuration() const {
  std::vector<int> states;
  for (std::size_t i = 1; i < active_.size(); ++i) {
    if (active_[i] != 0) states.push_back(static_cast<int>(i));
  }
  return states;
}

// selectTransitions and selectEventlessTransitions: for each atomic state in document order, the first enabled
// transition of the state or its nearest ancestor with one.
std::vector<int> Interpreter::Select(const std::string* event) const {
  std::vector<int> enabled;
  const Environment values = environment();
  const auto is_enabled = [&](const Transition& transition) {
    if (transition.events.empty() != (event == nullptr)) return false;
    if (event != nullptr && std::none_of(transition.events.begin(), transition.events.end(),
                                         [&](const std::string& descriptor) { return Matches(descriptor, *event); })) {
      return false;
    }
    return transition.condition.IsTrue(values);
  };
  const auto first_enabled = [&](int atomic) {
    for (int state = atomic; state >= 0; state = chart_.At(state).parent) {
      for (const int index : chart_.At(state).transitions) {
        if (is_enabled(chart_.transitions[static_cast<std::size_t>(index)])) return index;
      }
    }
    return -1;
  };
  for (const int state : Configuration()) {
    if (!chart_.At(state).is_atomic()) continue;
    const int index = first_enabled(state);
    if (index >= 0 && std::find(enabled.begin(), enabled.end(), index) == enabled.end()) enabled.push_back(index);
  }
  return WithoutConflicts(enabled);
}

// removeConflictingTransitions: of two transitions that exit a common state, the one with the inner source is kept,
// else the earlier one.
std::vector<int> Interpreter::WithoutConflicts(const std::vector<int>& enabled) const {
  std::vector<int> kept;
  for (const int candidate : enabled) {
    const Transition& t1 = chart_.transitions[static_cast<std::size_t>(candidate)];
    const std::vector<int> exits1 = ExitSet(t1);
    bool is_preempted = false;
    std::vector<int> overridden;
    for (const int other : kept) {
      const Transition& t2 = chart_.transitions[static_cast<std::size_t>(other)];
      const std::vector<int> exits2 = ExitSet(t2);
      const bool is_conflict =
          std::find_first_of(exits1.begin(), exits1.end(), exits2.begin(), exits2.end()) != exits1.end();
      if (!is_conflict) continue;
      if (chart_.IsDescendant(t1.source, t2.source)) {
        overridden.push_back(other);
      } else {
        is_preempted = true;
        break;
      }
    }
    if (is_preempted) continue;
    for (const int other : overridden) kept.erase(std::find(kept.begin(), kept.end(), other));
    kept.push_back(candidate);
  }
  return kept;
}

void Interpreter::Microstep(const std::vector<int>& transitions) {
  Exit(transitions);
  for (const int index : transitions) Execute(chart_.transitions[static_cast<std::size_t>(index)].actions);
  Enter(transitions);
}

// getEffectiveTargetStates: histories are replaced by the states that they stored, or by their default.
std::vector<int> Interpreter::EffectiveTargets(const Transition& transition) const {
  std::vector<int> targets;
  const auto add = [&](int state) {
    if (std::find(targets.begin(), targets.end(), state) == targets.end()) targets.push_back(state);
  };
  for (const int target : transition.targets) {
    if (chart_.At(target).kind != StateKind::kHistory) {
      add(target);
    } else if (const auto it = history_.find(target); it != history_.end()) {
      for (const int state : it->second) add(state);
    } else {
      const auto index = static_cast<std::size_t>(chart_.At(target).transitions.front());
      for (const int state : EffectiveTargets(chart_.transitions[index])) add(state);
    }
  }
  return targets;
}

// getTransitionDomain: the innermost compound state that stays active during the transition; -1: no state changes.
int Interpreter::Domain(const Transition& transition) const {
  const std::vector<int> targets = EffectiveTargets(transition);
  if (targets.empty()) return -1;
  const auto holds_all = [&](int ancestor) {
    return std::all_of(targets.begin(), targets.end(),
                       [&](int target) { return chart_.IsDescendant(target, ancestor); });
  };
  const State& source = chart_.At(transition.source);
  if (transition.is_internal && source.is_compound() && holds_all(transition.source)) return transition.source;
  for (int ancestor = source.parent; ancestor >= 0; ancestor = chart_.At(ancestor).parent) {
    if (chart_.At(ancestor).is_compound() && holds_all(ancestor)) return ancestor;
  }
  return 0;
}

std::vector<int> Interpreter::ExitSet(const Transition& transition) const {
  std::vector<int> states;
  const int domain = Domain(transition);
  if (domain < 0) return states;
  for (const int state : Configuration()) {
    if (chart_.IsDescendant(state, domain)) states.push_back(state);
  }
  return states;
}

void Interpreter::Exit(const std::vector<int>& transitions) {
  std::map<int, const Transition*, std::greater<>> leaving;  // exit order: reverse document order
  for (const int index : transitions) {
    const Transition& transition = chart_.transitions[static_cast<std::size_t>(index)];
    for (const int state : ExitSet(transition)) leaving.emplace(state, &transition);
  }
  for (const auto& [state, transition] : leaving) {
    for (const int history : chart_.At(state).histories) {
      std::vector<int>& remembered = history_[history];
      remembered.clear();
      for (const int child : chart_.At(state).children) {
        if (IsActive(child)) remembered.push_back(child);
      }
    }
  }
  for (const auto& [state, transition] : leaving) {
    Execute(chart_.At(state).on_exit);
    active_[static_cast<std::size_t>(state)] = 0;
    host_->OnExit(state, *transition, time_ns_);
  }
}

void Interpreter::Enter(const std::vector<int>& transitions) {
  for (const int index : transitions) {
    const Transition& transition = chart_.transitions[static_cast<std::size_t>(index)];
    if (!transition.targets.empty()) EnterTargets(transition.targets, EffectiveTargets(transition), Domain(transition));
  }
  EnterMarked();
}

// computeEntrySet for one transition.
void Interpreter::EnterTargets(const std::vector<int>& targets, const std::vector<int>& effective_targets, int domain) {
  for (const int target : targets) AddDescendants(target);
  for (const int target : effective_targets) AddAncestors(target, domain);
}

void Interpreter::AddDescendants(int state) {
  const State& entered = chart_.At(state);
  if (entered.kind == StateKind::kHistory) {
    const auto remembered = history_.find(state);
    const Transition& by_default = chart_.transitions[static_cast<std::size_t>(entered.transitions.front())];
    const bool is_remembered = remembered != history_.end();
    if (!is_remembered) history_actions_[entered.parent] = &by_default.actions;
    const std::vector<int>& targets = is_remembered ? remembered->second : by_default.targets;
    for (const int target : targets) AddDescendants(target);
    for (const int target : targets) AddAncestors(target, entered.parent);
    return;
  }
  to_enter_[static_cast<std::size_t>(state)] = 1;
  if (entered.is_compound()) {
    by_default_[static_cast<std::size_t>(state)] = 1;
    for (const int target : entered.initial) AddDescendants(target);
    for (const int target : entered.initial) AddAncestors(target, state);
  } else if (entered.kind == StateKind::kParallel) {
    AddMissingRegions(state);
  }
}

void Interpreter::AddAncestors(int state, int ancestor) {
  for (int up = chart_.At(state).parent; up >= 0 && up != ancestor; up = chart_.At(up).parent) {
    to_enter_[static_cast<std::size_t>(up)] = 1;
    if (chart_.At(up).kind == StateKind::kParallel) AddMissingRegions(up);
  }
}

// Every region of a parallel state without a descendant in the entry set is entered by default.
void Interpreter::AddMissingRegions(int parallel) {
  for (const int child : chart_.At(parallel).children) {
    bool is_entered = false;
    for (std::size_t i = 0; i < to_enter_.size() && !is_entered; ++i) {
      is_entered = to_enter_[i] != 0 && chart_.IsDescendant(static_cast<int>(i), child);
    }
    if (!is_entered) AddDescendants(child);
  }
}

void Interpreter::EnterMarked() {
  // Entry actions only queue events, so they cannot change the entry set.
  for (std::size_t i = 0; i < to_enter_.size(); ++i) {
    if (to_enter_[i] == 0) continue;
    const State& state = chart_.states[i];
    active_[i] = 1;
    host_->OnEnter(static_cast<int>(i), time_ns_);
    Execute(state.on_entry);
    if (by_default_[i] != 0) Execute(state.initial_actions);
    if (const auto it = history_actions_.find(static_cast<int>(i)); it != history_actions_.end()) Execute(*it->second);
    if (state.kind == StateKind::kFinal) AnnounceFinal(static_cast<int>(i));
  }
  std::fill(to_enter_.begin(), to_enter_.end(), char{0});
  std::fill(by_default_.begin(), by_default_.end(), char{0});
  history_actions_.clear();
}

void Interpreter::AnnounceFinal(int state) {
  const int parent = chart_.At(state).parent;
  if (parent == 0) {
    is_running_ = false;
    return;
  }
  internal_events_.push_back("done.state." + chart_.At(parent).id);
  const int grandparent = chart_.At(parent).parent;
  if (chart_.At(grandparent).kind != StateKind::kParallel) return;
  const std::vector<int>& regions = chart_.At(grandparent).children;
  if (std::all_of(regions.begin(), regions.end(), [&](int region) { return IsInFinal(region); })) {
    internal_events_.push_back("done.state." + chart_.At(grandparent).id);
  }
}

bool Interpreter::IsInFinal(int state) const {
  const State& checked = chart_.At(state);
  if (checked.kind == StateKind::kParallel) {
    return std::all_of(checked.children.begin(), checked.children.end(), [&](int child) { return IsInFinal(child); });
  }
  return std::any_of(checked.children.begin(), checked.children.end(),
                     [&](int child) { return chart_.At(child).kind == StateKind::kFinal && IsActive(child); });
}

void Interpreter::Execute(const std::vector<Action>& actions) {
  for (const Action& action : actions) Execute(action);
}

void Interpreter::Execute(const Action& action) {
  switch (action.kind) {
    case ActionKind::kRaise:
      internal_events_.push_back(action.text);
      return;
    case ActionKind::kSend:
      if (action.is_internal) {
        internal_events_.push_back(action.text);
      } else if (action.delay_ns > 0) {
        timers_.push_back({time_ns_ + action.delay_ns, num_sent_++, action.text, action.send_id});
      } else {
        sent_events_.push_back(action.text);
      }
      return;
    case ActionKind::kCancel:
      std::erase_if(timers_, [&](const Timer& timer) { return timer.send_id == action.text; });
      return;
    case ActionKind::kAssign:
      variables_[static_cast<std::size_t>(action.index)] = action.value.Evaluate(environment());
      return;
    case ActionKind::kIf:
      for (const Branch& branch : action.branches) {
        if (!branch.condition.IsTrue(environment())) continue;
        Execute(branch.actions);
        return;
      }
      return;
    case ActionKind::kSetParameter:
    case ActionKind::kLog: {
      const double value = action.value.Evaluate(environment());
      // The result of a division by zero must not reach another process.
      if (action.kind == ActionKind::kSetParameter && !std::isfinite(value)) {
        internal_events_.push_back("error.execution");
        return;
      }
      host_->OnAction(action, value);
      return;
    }
    case ActionKind::kLamp:
    case ActionKind::kHint:
      host_->OnAction(action, 0.0);
      return;
  }
}

}  // namespace logic_node::scxml
