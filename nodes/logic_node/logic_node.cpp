#include "nodes/logic_node/logic_node.hpp"

#include <algorithm>
#include <array>

#include "nodes/logic_node/scxml/analyse_chart.hpp"
#include "replay/step_codec.hpp"

namespace logic_node {
namespace {

// The procedure needs these nodes; it continues without others.
constexpr std::array<std::string_view, 3> kNeededNodes{"device_bridge", "haptic_node", "physics_node"};

bool IsNeeded(const std::string& node) {
  return std::any_of(kNeededNodes.begin(), kNeededNodes.end(),
                     [&](std::string_view needed) { return node.starts_with(needed); });
}

bool HasArrived(const core::PhysicsState* physics) {
  return physics != nullptr && (physics->header.sequence > 0 || physics->tick > 0 || !physics->bodies.empty() ||
                                !physics->mechanisms.empty());
}

bool IsSame(const core::LogicStatus& a, const core::LogicStatus& b) {
  const auto is_same_lamp = [](const core::LampState& x, const core::LampState& y) {
    return x.object == y.object && x.red == y.red && x.green == y.green && x.blue == y.blue;
  };
  return a.step == b.step && a.hint == b.hint && a.active_states == b.active_states && a.is_final == b.is_final &&
         a.is_failed == b.is_failed && a.why == b.why &&
         std::equal(a.lamps.begin(), a.lamps.end(), b.lamps.begin(), b.lamps.end(), is_same_lamp);
}

double Seconds(std::int64_t duration_ns) {
  return static_cast<double>(duration_ns) * 1e-9;
}

}  // namespace

std::string EventName(const core::Event& event) {
  std::string name = event.name;
  if (!event.detail.empty()) name += "." + event.detail;
  std::replace(name.begin(), name.end(), ' ', '.');
  return name;
}

core::Result<std::unique_ptr<LogicNode>> LogicNode::Create(const scene::Scenario& scenario) {
  std::unique_ptr<LogicNode> node(new LogicNode(scenario));
  auto chart = LoadProcedure(node->scenario_, &node->signals_);
  if (!chart) {
    std::string text;
    for (const scene::Diagnostic& diagnostic : chart.error()) {
      if (!text.empty()) text += "\n";
      text += scene::Format(diagnostic);
    }
    return core::Fail(core::ErrorCode::kInvalidInput, text);
  }
  node->chart_ = std::move(*chart);
  node->region_ = node->chart_.Find(scxml::kProcedureRegion);
  for (const int state : scxml::FindSteps(node->chart_)) {
    StepTimes step;
    step.state = state;
    step.record.name = node->chart_.At(state).id;
    node->steps_.push_back(step);
  }
  scxml::Host* host = node.get();
  node->interpreter_ = std::make_unique<scxml::Interpreter>(node->chart_, host);
  return node;
}

LogicNode::LogicNode(const scene::Scenario& scenario) : scenario_(scenario), signals_(scenario_) {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (!object.is_lamp) continue;
    status_.lamps.push_back(
        {static_cast<std::uint16_t>(i), object.lamp_color.r, object.lamp_color.g, object.lamp_color.b});
  }
  hint_ = "waiting for physics_node";
}

void LogicNode::Step(const Inputs& inputs, Outputs* outputs) {
  outputs_ = outputs;
  outputs->changes.clear();
  outputs->events.clear();
  const core::LogicStatus before = status_;
  UpdateLostNodes(inputs);
  if (!status_.is_failed && !status_.is_final && (is_started_ || HasArrived(inputs.physics))) {
    signals_.Update(inputs);
    if (!is_started_) {
      is_started_ = true;
      hint_.clear();
      interpreter_->Start(inputs.now_ns, &signals_.values());
    }
    std::vector<std::string> events;
    for (const core::Event& event : inputs.events) events.push_back(EventName(event));
    interpreter_->Advance(inputs.now_ns, events);
    CheckProgress(inputs);
  }
  UpdateStatus(inputs);
  outputs->is_status_changed = !IsSame(before, status_);
  outputs->status = status_;
  outputs_ = nullptr;
}

void LogicNode::UpdateLostNodes(const Inputs& inputs) {
  for (const core::Event& event : inputs.events) {
    const auto lost = std::find(lost_nodes_.begin(), lost_nodes_.end(), event.detail);
    if (event.name == "node_found" && lost != lost_nodes_.end()) lost_nodes_.erase(lost);
    // A viewer may leave at any time, and no other may come in its place.
    const bool is_missing = event.name == "node_lost" || (event.name == "node_left" && IsNeeded(event.detail));
    if (is_missing && lost == lost_nodes_.end()) lost_nodes_.push_back(event.detail);
    if (event.name != kNodeGone || status_.is_final || status_.is_failed || !IsNeeded(event.detail)) continue;
    const StepTimes* step = ActiveStep();
    Fail((step != nullptr ? "step " + step->record.name + ": " : "") + event.detail +
         " was lost: it no longer answers");
  }
}

void LogicNode::CheckProgress(const Inputs& inputs) {
  if (interpreter_->is_circling()) {
    Fail("the procedure does not come to rest: its transitions trigger each other endlessly at " +
         scxml::FormatNumber(Seconds(interpreter_->time_ns())) + " s");
    return;
  }
  for (const int child : chart_.At(region_).children) {
    if (chart_.At(child).kind == scxml::StateKind::kFinal && interpreter_->IsActive(child)) status_.is_final = true;
  }
  if (!interpreter_->is_running()) status_.is_final = true;
  if (status_.is_final) {
    for (const StepTimes& step : steps_) {
      if (step.record.is_entered && !step.record.is_completed) {
        Fail("step " + step.record.name + ": the procedure ended before it was completed; " + step.record.why);
        return;
      }
    }
    return;
  }
  const StepTimes* step = ActiveStep();
  if (step == nullptr) return;
  if (std::any_of(lost_nodes_.begin(), lost_nodes_.end(), IsNeeded)) last_lost_ns_ = inputs.now_ns;
  // Waiting for a lost node is no stall; when it has returned, the step has its full time again.
  const double seconds = Seconds(inputs.now_ns - std::max(step->entered_ns, last_lost_ns_));
  if (seconds > scenario_.stall_limit_s) {
    const std::string wait = DescribeWait(step->state);
    Fail("step " + step->record.name + ": no progress for " + scxml::FormatNumber(scenario_.stall_limit_s) + " s" +
         (wait.empty() ? "" : "; waiting for " + wait));
  }
}

void LogicNode::Fail(const std::string& why) {
  if (status_.is_failed) return;
  status_.is_failed = true;
  status_.why = why;
  if (StepTimes* step = ActiveStep()) step->record.why = why;
  outputs_->events.push_back({interpreter_->time_ns(), "logic_node", "procedure_failed", why});
}

// Unmet conditions of the step's completing transitions, from the innermost active state outwards; if it has none, of
// all its transitions.
std::string LogicNode::DescribeWait(int step) const {
  std::vector<std::string> waits;
  for (const bool is_completing : {true, false}) {
    const std::vector<int> active = interpreter_->Configuration();
    for (auto state = active.rbegin(); state != active.rend(); ++state) {
      if (*state != step && !chart_.IsDescendant(*state, step)) continue;
      for (const int index : chart_.At(*state).transitions) {
        const scxml::Transition& transition = chart_.transitions[static_cast<std::size_t>(index)];
        if (transition.is_completing != is_completing) continue;
        std::string wait = transition.condition.DescribeUnmet(interpreter_->environment());
        if (!transition.events.empty()) {
          std::string event = "event '" + transition.events.front() + "'";
          wait = wait.empty() ? event : event + " and " + wait;
        }
        if (!wait.empty()) waits.push_back(wait);
      }
    }
    if (!waits.empty()) break;
  }
  std::string text;
  for (std::size_t i = 0; i < waits.size() && i < 3; ++i) text += (i > 0 ? ", or " : "") + waits[i];
  return text;
}

LogicNode::StepTimes* LogicNode::FindStep(int state) {
  const auto it =
      std::find_if(steps_.begin(), steps_.end(), [&](const StepTimes& step) { return step.state == state; });
  return it == steps_.end() ? nullptr : &*it;
}

LogicNode::StepTimes* LogicNode::ActiveStep() {
  const auto it = std::find_if(steps_.begin(), steps_.end(), [](const StepTimes& step) { return step.is_active; });
  return it == steps_.end() ? nullptr : &*it;
}

void LogicNode::OnEnter(int state, std::int64_t time_ns) {
  StepTimes* step = FindStep(state);
  if (step == nullptr) return;
  step->is_active = true;
  step->entered_ns = time_ns;
  step->record.is_entered = true;
  step->record.is_completed = false;
  step->record.why.clear();
  outputs_->events.push_back({time_ns, "logic_node", "step_entered", step->record.name});
}

void LogicNode::OnExit(int state, const scxml::Transition& transition, std::int64_t time_ns) {
  StepTimes* step = FindStep(state);
  if (step == nullptr) return;
  step->is_active = false;
  step->record.seconds += Seconds(time_ns - step->entered_ns);
  step->record.is_completed = transition.is_completing;
  if (!transition.is_completing) {
    step->record.why = "left by a transition that does not complete it (line " + std::to_string(transition.line) + ")";
  }
  outputs_->events.push_back(
      {time_ns, "logic_node", transition.is_completing ? "step_completed" : "step_left", step->record.name});
}

void LogicNode::OnAction(const scxml::Action& action, double value) {
  switch (action.kind) {
    case scxml::ActionKind::kSetParameter:
      outputs_->changes.push_back({action.text, value, action.manner, action.ramp_s});
      return;
    case scxml::ActionKind::kHint:
      hint_ = action.text;
      return;
    case scxml::ActionKind::kLamp:
      for (core::LampState& lamp : status_.lamps) {
        if (lamp.object == action.index) lamp = {lamp.object, action.color[0], action.color[1], action.color[2]};
      }
      return;
    case scxml::ActionKind::kLog: {
      std::string text = action.text;
      if (!action.value.empty()) text += (text.empty() ? "" : ": ") + scxml::FormatNumber(value);
      outputs_->events.push_back({interpreter_->time_ns(), "logic_node", "log", text});
      return;
    }
    default:
      return;  // handled by the interpreter
  }
}

void LogicNode::UpdateStatus(const Inputs& inputs) {
  status_.time_ns = inputs.now_ns;
  const StepTimes* step = ActiveStep();
  if (step != nullptr) status_.step = step->record.name;
  if (status_.is_final) status_.step.clear();
  status_.active_states.clear();
  if (is_started_) {
    for (const int state : interpreter_->Configuration()) {
      if (!chart_.At(state).id.empty()) status_.active_states.push_back(chart_.At(state).id);
    }
  }
  status_.hint = hint_;
  for (const std::string& node : lost_nodes_) {
    status_.hint = node + " is lost" + (status_.hint.empty() ? "" : "; " + status_.hint);
  }
}

std::vector<StepRecord> LogicNode::steps() const {
  std::vector<StepRecord> records;
  for (const StepTimes& step : steps_) {
    StepRecord record = step.record;
    if (step.is_active) record.seconds += Seconds(status_.time_ns - step.entered_ns);
    if (!record.is_completed && record.why.empty()) record.why = record.is_entered ? "not finished" : "not reached";
    records.push_back(std::move(record));
  }
  return records;
}

template <class V>
void LogicNode::VisitState(V& v) {
  signals_.VisitState(v);
  interpreter_->VisitState(v);
  for (StepTimes& step : steps_) {
    v.Value("step.is_completed", step.record.is_completed);
    v.Value("step.is_entered", step.record.is_entered);
    v.Value("step.seconds", step.record.seconds);
    v.Text("step.why", step.record.why);
    v.Value("step.entered_ns", step.entered_ns);
    v.Value("step.is_active", step.is_active);
  }
  replay::Items(v, "lost_nodes", lost_nodes_);
  v.Value("last_lost_ns", last_lost_ns_);
  v.Text("hint", hint_);
  replay::Field(v, "status", status_);
  v.Value("is_started", is_started_);
}

std::vector<std::uint8_t> LogicNode::Save() const {
  constexpr std::size_t kMaxFields = 65536;
  replay::StepEncoder encoder(kMaxFields);
  encoder.Begin(0);
  const_cast<LogicNode*>(this)->VisitState(encoder);  // an encoder only reads the state
  const auto bytes = encoder.Finish(0);
  return {bytes.begin(), bytes.end()};
}

core::Result<void> LogicNode::Restore(const std::vector<std::uint8_t>& state) {
  replay::StepDecoder decoder;
  const std::size_t num_values = signals_.values().size();
  const std::size_t num_lamps = status_.lamps.size();
  if (decoder.Begin(state)) VisitState(decoder);
  if (!decoder.Finish() || signals_.values().size() != num_values || status_.lamps.size() != num_lamps ||
      !interpreter_->FitsChart()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "logic_node: the saved state is of another scenario or program version; start without it");
  }
  interpreter_->set_signals(&signals_.values());
  return {};
}

}  // namespace logic_node
