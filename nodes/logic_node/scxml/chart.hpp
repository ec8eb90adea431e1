#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/messages/logic.hpp"
#include "nodes/logic_node/scxml/expression.hpp"

namespace logic_node::scxml {

// A loaded chart: a subset of W3C SCXML with compiled expressions. States are numbered in document order, 0 is <scxml>;
// so ascending numbers are the recommendation's entry order, descending numbers its exit order.

enum class StateKind { kScxml, kState, kParallel, kFinal, kHistory };

enum class ActionKind { kLog, kRaise, kSend, kCancel, kAssign, kIf, kSetParameter, kLamp, kHint };

struct Branch;

// Executable content.
struct Action {
  ActionKind kind = ActionKind::kLog;
  std::string text;                                         // event, log label, hint, parameter name, send id to cancel
  std::string send_id;                                      // kSend; empty: none
  Expression value;                                         // kLog, kAssign, kSetParameter
  std::int64_t delay_ns = 0;                                // kSend
  bool is_internal = false;                                 // kSend with target #_internal
  core::ChangeManner manner = core::ChangeManner::kAtOnce;  // kSetParameter
  double ramp_s = 0.0;                                      // kSetParameter
  int index = -1;                                           // kAssign: variable; kLamp: object
  std::array<float, 3> color{};                             // kLamp
  std::vector<Branch> branches;                             // kIf: the first with a true condition is executed
  int line = 0;
};

struct Branch {
  Expression condition;  // empty: else
  std::vector<Action> actions;
};

struct Transition {
  int source = 0;
  std::vector<std::string> events;  // empty: eventless. Descriptors without a trailing ".*"; "*" matches all
  Expression condition;
  std::vector<int> targets;  // empty: stays
  bool is_internal = false;
  bool is_completing = false;  // vr:completes: leaving a step this way completes it
  std::vector<Action> actions;
  int line = 0;
};

struct State {
  std::string id;
  StateKind kind = StateKind::kState;
  int parent = -1;
  std::vector<int> children;  // states, parallels and finals in document order; not histories
  std::vector<int> histories;
  std::vector<int> initial;  // targets of the default entry of a compound state
  std::vector<Action> initial_actions;
  std::vector<int> transitions;  // indices into Chart::transitions, in document order; of a history: its default
  std::vector<Action> on_entry;
  std::vector<Action> on_exit;
  int line = 0;

  // Has child states, exactly one of which is active.
  [[nodiscard]] bool is_compound() const {
    return (kind == StateKind::kState || kind == StateKind::kScxml) && !children.empty();
  }
  [[nodiscard]] bool is_atomic() const {
    return kind == StateKind::kFinal || (kind == StateKind::kState && children.empty());
  }
};

struct Variable {
  std::string id;
  Expression initial;
};

struct Chart {
  std::filesystem::path file;
  std::vector<State> states;
  std::vector<Transition> transitions;
  std::vector<Variable> variables;

  [[nodiscard]] int Find(const std::string& id) const {
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (!id.empty() && states[i].id == id) return static_cast<int>(i);
    }
    return -1;
  }
  [[nodiscard]] const State& At(int state) const { return states[static_cast<std::size_t>(state)]; }
  // Proper descent: a state is not its own descendant.
  [[nodiscard]] bool IsDescendant(int state, int ancestor) const {
    for (int up = At(state).parent; up >= 0; up = At(up).parent) {
      if (up == ancestor) return true;
    }
    return false;
  }
};

}  // namespace logic_node::scxml
