#include "nodes/logic_node/scxml/analyse_chart.hpp"

#include <algorithm>

namespace logic_node::scxml {
namespace {

class Walk {
 public:
  explicit Walk(const Chart& chart)
      : chart_(chart), is_reachable_(chart.states.size(), 0), has_default_(is_reachable_) {}

  std::vector<char> Run() {
    EnterByDefault(0);
    return std::move(is_reachable_);
  }

 private:
  // Marks a state and the states that are entered with it as reachable. Expands each state once.
  void Enter(int state) {
    if (state < 0 || is_reachable_[static_cast<std::size_t>(state)] != 0) return;
    is_reachable_[static_cast<std::size_t>(state)] = 1;
    const State& entered = chart_.At(state);
    Enter(entered.parent);
    if (entered.kind == StateKind::kParallel) {
      for (const int child : entered.children) EnterByDefault(child);
    }
    for (const int index : entered.transitions) {
      const Transition& transition = chart_.transitions[static_cast<std::size_t>(index)];
      const auto constant = transition.condition.ConstantValue();
      if (!transition.condition.empty() && constant && *constant == 0.0) continue;
      for (const int target : transition.targets) EnterByDefault(target);
    }
  }

  // A target is entered with its default children, a state entered only as an ancestor without. A history restores
  // states that were entered before, so it adds only its default.
  void EnterByDefault(int state) {
    Enter(state);
    if (has_default_[static_cast<std::size_t>(state)] != 0) return;
    has_default_[static_cast<std::size_t>(state)] = 1;
    for (const int target : chart_.At(state).initial) EnterByDefault(target);
  }

  const Chart& chart_;
  std::vector<char> is_reachable_;
  std::vector<char> has_default_;
};

std::string Name(const State& state) {
  return state.id.empty() ? "without id" : "'" + state.id + "'";
}

class Analysis {
 public:
  explicit Analysis(const Chart& chart) : chart_(chart), is_reachable_(FindReachable(chart)) {}

  std::vector<scene::Diagnostic> Run() {
    for (std::size_t i = 0; i < chart_.states.size(); ++i) {
      const State& state = chart_.states[i];
      // One message for a whole unreachable branch, at its topmost state.
      if (is_reachable_[i] != 0 || is_reachable_[static_cast<std::size_t>(state.parent)] == 0) continue;
      Report(state.line, "state " + Name(state) + " cannot be reached",
             "no reachable transition leads to it and it is not an initial state",
             "add a transition with target=\"" + state.id + "\", or remove the state");
    }
    CheckProcedure();
    std::stable_sort(diagnostics_.begin(), diagnostics_.end(),
                     [](const auto& a, const auto& b) { return a.where.line < b.where.line; });
    return std::move(diagnostics_);
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_.push_back({{chart_.file, line}, std::move(what), std::move(why), std::move(fix)});
  }

  void CheckProcedure() {
    const int region = chart_.Find(kProcedureRegion);
    if (region < 0 || !chart_.At(region).is_compound()) {
      Report(chart_.states[0].line, "no state 'procedure' with steps in it",
             "its child states are the steps of the report, and its final state ends the run",
             "add <state id=\"procedure\"> with a state per step and a <final>");
      return;
    }
    const std::vector<int>& children = chart_.At(region).children;
    const auto is_final = [&](int child) { return chart_.At(child).kind == StateKind::kFinal; };
    if (std::none_of(children.begin(), children.end(), is_final)) {
      Report(chart_.At(region).line, "the procedure has no final state", "the run would never end",
             "add <final id=\"done\"/> to 'procedure' and a transition to it");
      return;
    }
    if (FindSteps(chart_).empty()) {
      Report(chart_.At(region).line, "the procedure has no steps", "the report would be empty",
             "add a <state> for each step to 'procedure'");
    }
    for (const int step : FindSteps(chart_)) CheckStep(step, region);
  }

  void CheckStep(int step, int region) {
    const State& state = chart_.At(step);
    if (state.id.empty()) {
      Report(state.line, "a step without id", "the report names steps by their ids", "add id=\"...\"");
    }
    if (is_reachable_[static_cast<std::size_t>(step)] == 0) return;  // reported
    bool is_completable = false;
    for (const Transition& transition : chart_.transitions) {
      is_completable =
          is_completable || (transition.is_completing && IsInside(transition.source, step) && Leaves(transition, step));
    }
    if (!is_completable) {
      Report(state.line, "step " + Name(state) + " can never be completed",
             "no transition out of it is marked vr:completes=\"true\"",
             "mark the one that is taken when the step is done");
    }
    if (!LeadsToFinal(step, region)) {
      Report(state.line, "no path leads from step " + Name(state) + " to the procedure's final state",
             "the run would stall there", "add a transition from it towards the final state");
    }
  }

  [[nodiscard]] bool IsInside(int state, int ancestor) const {
    return state == ancestor || chart_.IsDescendant(state, ancestor);
  }
  [[nodiscard]] bool Leaves(const Transition& transition, int step) const {
    return std::any_of(transition.targets.begin(), transition.targets.end(),
                       [&](int target) { return !IsInside(target, step); });
  }

  // Breadth-first search over the region's children; an edge is a transition from inside or above a child to another.
  [[nodiscard]] bool LeadsToFinal(int step, int region) const {
    std::vector<int> reached{step};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (chart_.At(reached[i]).kind == StateKind::kFinal) return true;
      for (const Transition& transition : chart_.transitions) {
        const bool can_fire = IsInside(transition.source, reached[i]) || !IsInside(transition.source, region) ||
                              transition.source == region;
        if (!can_fire) continue;
        for (const int target : transition.targets) {
          for (const int child : chart_.At(region).children) {
            if (IsInside(target, child) && std::find(reached.begin(), reached.end(), child) == reached.end()) {
              reached.push_back(child);
            }
          }
        }
      }
    }
    return false;
  }

  const Chart& chart_;
  std::vector<char> is_reachable_;
  std::vector<scene::Diagnostic> diagnostics_;
};

}  // namespace

std::vector<int> FindSteps(const Chart& chart) {
  std::vector<int> steps;
  const int region = chart.Find(kProcedureRegion);
  if (region < 0) return steps;
  for (const int child : chart.At(region).children) {
    if (chart.At(child).kind != StateKind::kFinal) steps.push_back(child);
  }
  return steps;
}

std::vector<char> FindReachable(const Chart& chart) {
  return Walk(chart).Run();
}

std::vector<scene::Diagnostic> AnalyseChart(const Chart& chart) {
  return Analysis(chart).Run();
}

}  // namespace logic_node::scxml
