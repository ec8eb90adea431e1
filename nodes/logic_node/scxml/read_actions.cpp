#include "nodes/logic_node/scxml/read_actions.hpp"

#include <algorithm>
#include <cmath>

#include "core/names.hpp"
#include "scene/schema.hpp"

namespace logic_node::scxml {

using scene::XmlElement;

std::string TagOf(const XmlElement& element) {
  return (element.name_space == kProcedureNamespace ? "vr:" : "") + element.name;
}

namespace {

// Prefix of a message about an element.
std::string InTag(const XmlElement& element) {
  return std::string(1, '<').append(TagOf(element)).append(">: ");
}

}  // namespace

ActionReader::ActionReader(const Vocabulary& vocabulary, Chart* chart, std::vector<scene::Diagnostic>* diagnostics)
    : vocabulary_(vocabulary), chart_(*chart), diagnostics_(*diagnostics) {
  scope_.find_symbol = [this](const std::string& name) -> std::optional<Symbol> {
    if (const auto it = variables_.find(name); it != variables_.end()) {
      const auto slot = static_cast<std::size_t>(it->second);
      return Symbol{SymbolKind::kVariable, chart_.variables[slot].initial.type(), it->second};
    }
    return vocabulary_.find_signal ? vocabulary_.find_signal(name) : std::nullopt;
  };
  scope_.find_state = [this](const std::string& id) -> std::optional<int> {
    const int state = chart_.Find(id);
    return state < 0 ? std::nullopt : std::optional<int>(state);
  };
  scope_.suggest = vocabulary_.suggest_signal;
}

void ActionReader::Report(int line, std::string what, std::string why, std::string fix) {
  diagnostics_.push_back({{chart_.file, line}, std::move(what), std::move(why), std::move(fix)});
}

void ActionReader::ReadVariable(const XmlElement& data) {
  const std::string id = data.Get("id");
  if (id.empty() || variables_.count(id) > 0) {
    Report(data.line, id.empty() ? "<data> without id" : "a second <data> '" + id + "'",
           "expressions refer to data by id", "give each <data> a unique id");
    return;
  }
  Variable variable{id, Compile(data, "expr", true)};
  variables_.emplace(id, static_cast<int>(chart_.variables.size()));
  chart_.variables.push_back(std::move(variable));
}

Expression ActionReader::Compile(const XmlElement& element, const char* attribute, bool is_required,
                                 std::optional<Type> wanted) {
  const std::string text = element.Get(attribute);
  if (text.empty()) {
    if (is_required || element.Find(attribute) != nullptr) {
      Report(element.LineOf(attribute), InTag(element) + attribute + " is missing", "it needs a value",
             "add " + std::string(attribute) + "=\"...\"");
    }
    return {};
  }
  auto expression = Expression::Compile(text, scope_);
  if (!expression) {
    const ExpressionError& error = expression.error();
    Report(element.LineOf(attribute), std::string(attribute) + " \"" + text + "\": " + error.what, error.why,
           error.fix);
    return {};
  }
  if (wanted && expression->type() != *wanted && expression->type() != Type::kFlag) {
    const bool is_boolean = *wanted == Type::kBoolean;
    Report(element.LineOf(attribute),
           std::string(attribute) + " \"" + text + "\" is a " + (is_boolean ? "number" : "boolean"),
           is_boolean ? "a condition must be a boolean" : "a number is needed here",
           is_boolean ? "compare it, as in " + text + " == 1" : "write a number");
  }
  return std::move(*expression);
}

std::vector<Action> ActionReader::ReadActions(const XmlElement& element) {
  std::vector<Action> actions;
  for (const XmlElement& child : element.children) {
    if (const auto action = ReadAction(child)) actions.push_back(*action);
  }
  return actions;
}

std::string ActionReader::Required(const XmlElement& element, const char* attribute) {
  const std::string value = element.Get(attribute);
  if (value.empty()) {
    Report(element.line, InTag(element) + attribute + " is missing", "the element has no effect without it",
           "add " + std::string(attribute) + "=\"...\"");
  }
  return value;
}

std::optional<Action> ActionReader::ReadAction(const XmlElement& element) {
  const std::string tag = TagOf(element);
  Action action;
  action.line = element.line;
  if (tag == "log") {
    action.kind = ActionKind::kLog;
    action.text = element.Get("label");
    action.value = Compile(element, "expr", false);
  } else if (tag == "raise") {
    action.kind = ActionKind::kRaise;
    action.text = Required(element, "event");
  } else if (tag == "send") {
    ReadSend(element, &action);
  } else if (tag == "cancel") {
    action.kind = ActionKind::kCancel;
    action.text = Required(element, "sendid");
  } else if (tag == "assign") {
    ReadAssign(element, &action);
  } else if (tag == "if") {
    ReadIf(element, &action);
  } else if (tag == "vr:set") {
    ReadSet(element, &action);
  } else if (tag == "vr:lamp") {
    ReadLamp(element, &action);
  } else if (tag == "vr:hint") {
    action.kind = ActionKind::kHint;
    action.text = element.Get("text");
  } else {
    if (KnownAttributes().count(tag) > 0) {
      Report(element.line, "<" + tag + "> is not executable content", "only actions are allowed here",
             "move it into a <state>");
    }
    return std::nullopt;
  }
  return action;
}

void ActionReader::ReadSend(const XmlElement& element, Action* action) {
  action->kind = ActionKind::kSend;
  action->text = Required(element, "event");
  action->send_id = element.Get("id");
  const std::string target = element.Get("target");
  action->is_internal = target == "#_internal";
  if (!target.empty() && !action->is_internal) {
    Report(element.LineOf("target"), "<send>: target '" + target + "'", "events are sent only to the chart itself",
           "remove target, or write \"#_internal\"");
  }
  const std::string delay = element.Get("delay");
  if (delay.empty()) return;
  // CSS2 times: a number and s or ms. Bus time is counted in whole nanoseconds.
  const bool is_ms = delay.ends_with("ms");
  const bool is_s = !is_ms && delay.ends_with("s");
  double amount = 0.0;
  if ((!is_ms && !is_s) || !scene::ParseNumber(delay.substr(0, delay.size() - (is_ms ? 2 : 1)), &amount) ||
      amount < 0.0 || amount > 1e6) {
    Report(element.LineOf("delay"), "<send>: delay is '" + delay + "'", "it must be a time of 0 or more",
           "write \"3s\" or \"200ms\"");
    return;
  }
  if (action->is_internal) {
    Report(element.LineOf("delay"), "<send>: delay on an internal event",
           "internal events are processed in the same step", "remove delay or target");
  }
  action->delay_ns = std::llround(amount * (is_ms ? 1e6 : 1e9));
}

void ActionReader::ReadAssign(const XmlElement& element, Action* action) {
  action->kind = ActionKind::kAssign;
  const std::string location = Required(element, "location");
  const auto it = variables_.find(location);
  std::vector<std::string> names;
  for (const auto& [name, index] : variables_) names.push_back(name);
  if (it == variables_.end()) {
    if (!location.empty()) {
      Report(element.LineOf("location"), "<assign>: unknown location '" + location + "'",
             "it must be the id of a <data>", core::SuggestName(location, names));
    }
    return;
  }
  action->index = it->second;
  const Type type = chart_.variables[static_cast<std::size_t>(it->second)].initial.type();
  action->value = Compile(element, "expr", true, type == Type::kBoolean ? Type::kBoolean : Type::kNumber);
}

void ActionReader::ReadIf(const XmlElement& element, Action* action) {
  action->kind = ActionKind::kIf;
  action->branches.push_back({Compile(element, "cond", true, Type::kBoolean), {}});
  bool has_else = false;
  for (const XmlElement& child : element.children) {
    if (child.name == "elseif" || child.name == "else") {
      if (has_else) {
        Report(child.line, "<" + child.name + "> after <else>", "<else> is the last branch", "move it before <else>");
      }
      has_else = child.name == "else";
      action->branches.push_back({has_else ? Expression() : Compile(child, "cond", true, Type::kBoolean), {}});
    } else if (const auto inner = ReadAction(child)) {
      action->branches.back().actions.push_back(*inner);
    }
  }
}

void ActionReader::ReadSet(const XmlElement& element, Action* action) {
  action->kind = ActionKind::kSetParameter;
  action->text = Required(element, "name");
  if (!action->text.empty() && (!vocabulary_.is_parameter || !vocabulary_.is_parameter(action->text))) {
    Report(element.LineOf("name"), "<vr:set>: unknown parameter '" + action->text + "'",
           "no node has a parameter of that name in this scenario",
           vocabulary_.suggest_parameter ? vocabulary_.suggest_parameter(action->text) : "correct the name");
  }
  action->value = Compile(element, "value", true, Type::kNumber);
  ReadManner(element, action);
}

void ActionReader::ReadManner(const XmlElement& element, Action* action) {
  const std::string over = element.Get("over_s");
  const std::string when = element.Get("when");
  if (!over.empty() && !when.empty()) {
    Report(element.line, "<vr:set>: both over_s and when", "a change is either ramped or held", "remove one of them");
  } else if (!over.empty()) {
    action->manner = core::ChangeManner::kRamped;
    if (!scene::ParseNumber(over, &action->ramp_s) || !(action->ramp_s > 0.0)) {
      Report(element.LineOf("over_s"), "<vr:set>: over_s is '" + over + "'", "it must be a time above 0 in seconds",
             "write for example \"0.5\"");
    }
  } else if (when == "separated") {
    action->manner = core::ChangeManner::kWhenSeparated;
  } else if (!when.empty()) {
    Report(element.LineOf("when"), "<vr:set>: when is '" + when + "'", "the only choice is \"separated\"",
           "write when=\"separated\", or remove it");
  }
}

void ActionReader::ReadLamp(const XmlElement& element, Action* action) {
  action->kind = ActionKind::kLamp;
  const std::string object = Required(element, "object");
  const auto lamp = vocabulary_.find_lamp ? vocabulary_.find_lamp(object) : std::nullopt;
  if (lamp) {
    action->index = *lamp;
  } else if (!object.empty()) {
    Report(element.LineOf("object"), "<vr:lamp>: '" + object + "' is not a lamp",
           "it must be an <object> with a <lamp>",
           vocabulary_.suggest_lamp ? vocabulary_.suggest_lamp(object) : "correct the name");
  }
  std::vector<double> color;
  if (!scene::ParseNumbers(element.Get("color"), &color) || color.size() != 3 ||
      std::any_of(color.begin(), color.end(), [](double part) { return part < 0.0 || part > 1.0; })) {
    Report(element.LineOf("color"), "<vr:lamp>: color is '" + element.Get("color") + "'",
           "it must be red, green and blue from 0 to 1", "write for example \"0 1 0\"");
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) action->color[i] = static_cast<float>(color[i]);
}

}  // namespace logic_node::scxml
