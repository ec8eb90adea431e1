#include "nodes/logic_node/scxml/load_chart.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "scene/schema.hpp"
#include "scene/xml.hpp"

namespace logic_node::scxml {
namespace {

using scene::Diagnostic;
using scene::XmlElement;

// Attributes of each element of the subset; those of vr: elements under "vr:".
const std::map<std::string, std::vector<std::string>>& KnownAttributes() {
  static const std::map<std::string, std::vector<std::string>> known{
      {"scxml", {"version", "initial", "name", "datamodel", "binding"}},
      {"state", {"id", "initial"}},
      {"parallel", {"id"}},
      {"initial", {}},
      {"final", {"id"}},
      {"history", {"id", "type"}},
      {"transition", {"event", "cond", "target", "type"}},
      {"onentry", {}},
      {"onexit", {}},
      {"log", {"label", "expr"}},
      {"raise", {"event"}},
      {"send", {"event", "id", "delay", "target"}},
      {"cancel", {"sendid"}},
      {"assign", {"location", "expr"}},
      {"if", {"cond"}},
      {"elseif", {"cond"}},
      {"else", {}},
      {"datamodel", {}},
      {"data", {"id", "expr"}},
      {"vr:set", {"name", "value"}},
      {"vr:lamp", {"object", "color"}},
      {"vr:hint", {"text"}},
  };
  return known;
}

std::string TagOf(const XmlElement& element) {
  return (element.name_space == kProcedureNamespace ? "vr:" : "") + element.name;
}

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

class Loader {
 public:
  Loader(const std::filesystem::path& file, const Vocabulary& vocabulary) : vocabulary_(vocabulary) {
    chart_.file = file;
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

  tl::expected<Chart, std::vector<Diagnostic>> Run() {
    const auto root = scene::ReadXml(chart_.file);
    if (!root) return tl::unexpected(root.error());
    if (root->name != "scxml" || root->name_space != kScxmlNamespace) {
      Say(root->line, "the root element is <" + root->name + ">", "a procedure is an SCXML document",
          "start with <scxml xmlns=\"" + std::string(kScxmlNamespace) + "\" xmlns:vr=\"" + kProcedureNamespace +
              "\" version=\"1.0\">");
      return tl::unexpected(std::move(diagnostics_));
    }
    CheckElements(*root);
    AddStates(*root, -1);  // first all ids, since targets and In() may look ahead
    ReadData(*root);
    for (std::size_t i = 0; i < chart_.states.size(); ++i) ReadState(static_cast<int>(i), *elements_[i]);
    if (!diagnostics_.empty()) {
      std::stable_sort(diagnostics_.begin(), diagnostics_.end(),
                       [](const Diagnostic& a, const Diagnostic& b) { return a.where.line < b.where.line; });
      return tl::unexpected(std::move(diagnostics_));
    }
    return std::move(chart_);
  }

 private:
  void Say(int line, std::string what, std::string why, std::string fix) {
    diagnostics_.push_back({{chart_.file, line}, std::move(what), std::move(why), std::move(fix)});
  }

  // Elements and attributes that the interpreter does not know would be silently without effect: they are refused.
  void CheckElements(const XmlElement& element) {
    static const std::map<std::string, std::string> kRefused{
        {"script", "procedures run no scripts, so that every run can be repeated exactly"},
        {"invoke", "procedures start no other services"},
        {"foreach", "the data of a procedure are single numbers"},
        {"param", "events carry no data"},
        {"content", "events carry no data"},
        {"donedata", "events carry no data"},
        {"finalize", "procedures start no other services"},
    };
    const std::string tag = TagOf(element);
    const bool is_known_space = element.name_space == kScxmlNamespace || element.name_space == kProcedureNamespace;
    const auto known = KnownAttributes().find(tag);
    if (known == KnownAttributes().end() || !is_known_space) {
      const auto refused = kRefused.find(element.name);
      if (refused != kRefused.end() && is_known_space) {
        Say(element.line, "<" + tag + "> is not supported", refused->second,
            "express it with states, transitions, <assign>, <send> and <vr:set>");
        return;
      }
      std::vector<std::string> tags;
      for (const auto& [name, attributes] : KnownAttributes()) tags.push_back(name);
      Say(element.line, "unknown element <" + tag + ">",
          is_known_space ? "it is not in the SCXML subset that procedures are written in"
                         : "its namespace '" + element.name_space + "' is neither SCXML's nor " + kProcedureNamespace,
          is_known_space ? scene::SuggestName(tag, tags) : "correct xmlns or the prefix");
      return;
    }
    for (const scene::XmlAttribute& attribute : element.attributes) {
      if (attribute.name_space == kProcedureNamespace && tag == "transition" && attribute.name == "completes") continue;
      if (attribute.name_space.empty() &&
          std::find(known->second.begin(), known->second.end(), attribute.name) != known->second.end()) {
        continue;
      }
      std::vector<std::string> names = known->second;
      if (tag == "transition") names.emplace_back("vr:completes");
      const std::string prefix = attribute.name_space == kProcedureNamespace ? "vr:" : "";
      Say(attribute.line, "<" + tag + ">: unknown attribute '" + prefix + attribute.name + "'",
          "it is not in the SCXML subset that procedures are written in", scene::SuggestName(attribute.name, names));
    }
    for (const XmlElement& child : element.children) CheckElements(child);
  }

  static std::optional<StateKind> KindOf(const XmlElement& element) {
    if (element.name_space != kScxmlNamespace) return std::nullopt;
    if (element.name == "scxml") return StateKind::kScxml;
    if (element.name == "state") return StateKind::kState;
    if (element.name == "parallel") return StateKind::kParallel;
    if (element.name == "final") return StateKind::kFinal;
    if (element.name == "history") return StateKind::kHistory;
    return std::nullopt;
  }

  void AddStates(const XmlElement& element, int parent) {
    const int index = static_cast<int>(chart_.states.size());
    State state;
    state.kind = *KindOf(element);
    state.id = state.kind == StateKind::kScxml ? "" : element.Get("id");
    state.parent = parent;
    state.line = element.line;
    if (!state.id.empty()) {
      const int other = chart_.Find(state.id);
      if (other >= 0) {
        Say(element.LineOf("id"), "a second state '" + state.id + "'",
            "the id is taken by line " + std::to_string(chart_.At(other).line), "rename one of them");
      }
      if (state.id.find_first_of(" \t\n") != std::string::npos) {
        Say(element.LineOf("id"), "the id '" + state.id + "' holds a blank", "blanks separate ids in lists",
            "replace it by '_'");
      }
    }
    if (parent >= 0) {
      State& up = chart_.states[static_cast<std::size_t>(parent)];
      (state.kind == StateKind::kHistory ? up.histories : up.children).push_back(index);
    }
    chart_.states.push_back(std::move(state));
    elements_.push_back(&element);
    for (const XmlElement& child : element.children) {
      const auto kind = KindOf(child);
      if (!kind) continue;
      const StateKind own = chart_.At(index).kind;
      const bool is_allowed = own == StateKind::kScxml ? *kind != StateKind::kHistory
                                                       : own == StateKind::kState || (own == StateKind::kParallel &&
                                                                                      *kind != StateKind::kFinal);
      if (!is_allowed || *kind == StateKind::kScxml) {
        Say(child.line, "<" + child.name + "> inside <" + element.name + ">", "SCXML does not allow it there",
            "move it into a <state>");
        continue;
      }
      AddStates(child, index);
    }
  }

  void ReadData(const XmlElement& element) {
    for (const XmlElement& child : element.children) {
      if (child.name == "datamodel") {
        for (const XmlElement& data : child.children) {
          if (data.name == "data") ReadVariable(data);
        }
      } else {
        ReadData(child);
      }
    }
  }

  void ReadVariable(const XmlElement& data) {
    const std::string id = data.Get("id");
    if (id.empty() || variables_.count(id) > 0) {
      Say(data.line, id.empty() ? "<data> without id" : "a second <data> '" + id + "'", "data are found by their id",
          "give each <data> an id of its own");
      return;
    }
    Variable variable{id, Compile(data, "expr", true)};
    variables_.emplace(id, static_cast<int>(chart_.variables.size()));
    chart_.variables.push_back(std::move(variable));
  }

  // Compiles an attribute. Absent: an empty expression, and a message when it is required.
  Expression Compile(const XmlElement& element, const char* attribute, bool is_required,
                     std::optional<Type> wanted = std::nullopt) {
    const std::string text = element.Get(attribute);
    if (text.empty()) {
      if (is_required || element.Find(attribute) != nullptr) {
        Say(element.LineOf(attribute), "<" + TagOf(element) + ">: " + attribute + " is missing", "it needs a value",
            "add " + std::string(attribute) + "=\"...\"");
      }
      return {};
    }
    auto expression = Expression::Compile(text, scope_);
    if (!expression) {
      const ExpressionError& error = expression.error();
      Say(element.LineOf(attribute), std::string(attribute) + " \"" + text + "\": " + error.what, error.why, error.fix);
      return {};
    }
    if (wanted && expression->type() != *wanted && expression->type() != Type::kFlag) {
      const bool is_truth = *wanted == Type::kTruth;
      Say(element.LineOf(attribute),
          std::string(attribute) + " \"" + text + "\" is a " + (is_truth ? "number" : "truth"),
          is_truth ? "a condition holds or does not hold" : "a number is needed here",
          is_truth ? "compare it, as in " + text + " == 1" : "write a number");
    }
    return std::move(*expression);
  }

  void ReadState(int index, const XmlElement& element) {
    if (chart_.At(index).kind == StateKind::kHistory) {
      ReadHistory(index, element);
      return;
    }
    int num_initial_elements = 0;
    for (const XmlElement& child : element.children) {
      if (child.name == "onentry") Append(ReadActions(child), &chart_.states[static_cast<std::size_t>(index)].on_entry);
      if (child.name == "onexit") Append(ReadActions(child), &chart_.states[static_cast<std::size_t>(index)].on_exit);
      if (child.name == "initial") {
        ++num_initial_elements;
        ReadInitialElement(index, child);
      }
      if (child.name == "transition") {
        if (chart_.At(index).kind == StateKind::kScxml || chart_.At(index).kind == StateKind::kFinal) {
          Say(child.line, "<transition> inside <" + element.name + ">", "only states have transitions",
              "move it into a <state>");
          continue;
        }
        const int transition = ReadTransition(index, child, false);
        chart_.states[static_cast<std::size_t>(index)].transitions.push_back(transition);
      }
    }
    ReadInitial(index, element, num_initial_elements);
  }

  static void Append(std::vector<Action> actions, std::vector<Action>* to) {
    for (Action& action : actions) to->push_back(std::move(action));
  }

  void ReadInitialElement(int index, const XmlElement& element) {
    if (element.children.size() != 1 || element.children[0].name != "transition") {
      Say(element.line, "<initial> without a transition", "it holds exactly one, which says where to begin",
          "write <initial><transition target=\"...\"/></initial>");
      return;
    }
    const int transition_index = ReadTransition(index, element.children[0], true);
    Transition transition = std::move(chart_.transitions[static_cast<std::size_t>(transition_index)]);
    chart_.transitions.pop_back();
    State& state = chart_.states[static_cast<std::size_t>(index)];
    state.initial = std::move(transition.targets);
    state.initial_actions = std::move(transition.actions);
    CheckInside(index, state.initial, element.line, "<initial>");
  }

  void ReadInitial(int index, const XmlElement& element, int num_initial_elements) {
    State& state = chart_.states[static_cast<std::size_t>(index)];
    const scene::XmlAttribute* attribute = element.Find("initial");
    if (attribute != nullptr && num_initial_elements > 0) {
      Say(attribute->line, "initial twice", "the attribute and the element say the same thing", "remove one of them");
      return;
    }
    if (attribute != nullptr) {
      state.initial = Targets(attribute->value, attribute->line);
      CheckInside(index, state.initial, attribute->line, "initial");
    }
    if (state.kind == StateKind::kScxml && state.children.empty()) {
      Say(element.line, "<scxml> without states", "there is nothing to run", "add a <state>");
    } else if (state.is_compound() && state.initial.empty() && num_initial_elements == 0) {
      state.initial = {state.children.front()};
    }
  }

  void CheckInside(int index, const std::vector<int>& targets, int line, const std::string& title) {
    for (const int target : targets) {
      if (chart_.IsDescendant(target, index)) continue;
      Say(line, title + ": '" + chart_.At(target).id + "' is not inside the state", "a state begins in one of its own",
          "name a state inside '" + chart_.At(index).id + "'");
    }
  }

  void ReadHistory(int index, const XmlElement& element) {
    if (const std::string type = element.Get("type", "shallow"); type != "shallow") {
      Say(element.LineOf("type"), "history of type '" + type + "'", "only shallow histories are supported",
          "write type=\"shallow\", or one history per level");
    }
    std::vector<const XmlElement*> transitions;
    for (const XmlElement& child : element.children) {
      if (child.name == "transition") transitions.push_back(&child);
    }
    if (transitions.size() != 1) {
      Say(element.line,
          "history '" + chart_.At(index).id + "' with " + std::to_string(transitions.size()) + " transitions",
          "it needs one, for the time when there is nothing to remember", "add <transition target=\"...\"/>");
      return;
    }
    const int transition = ReadTransition(index, *transitions[0], true);
    CheckInside(chart_.At(index).parent, chart_.transitions[static_cast<std::size_t>(transition)].targets,
                transitions[0]->line, "history");
    chart_.states[static_cast<std::size_t>(index)].transitions.push_back(transition);
  }

  // A default transition (of <initial> and <history>) has neither event nor condition, but a target.
  int ReadTransition(int source, const XmlElement& element, bool is_default) {
    Transition transition;
    transition.source = source;
    transition.line = element.line;
    for (std::string event : Words(element.Get("event"))) {
      if (event.size() > 2 && event.ends_with(".*")) event.resize(event.size() - 2);
      CheckDoneEvent(element, event);
      transition.events.push_back(std::move(event));
    }
    transition.condition = Compile(element, "cond", false, Type::kTruth);
    transition.targets = Targets(element.Get("target"), element.LineOf("target"));
    const std::string type = element.Get("type", "external");
    if (type != "internal" && type != "external") {
      Say(element.LineOf("type"), "transition of type '" + type + "'", "it is internal or external",
          "write one of them");
    }
    transition.is_internal = type == "internal";
    if (const scene::XmlAttribute* completes = element.Find("completes", kProcedureNamespace)) {
      if (!scene::ParseTruth(completes->value, &transition.is_completing)) {
        Say(completes->line, "vr:completes is '" + completes->value + "'", "it is true or false", "write \"true\"");
      }
    }
    const bool has_condition = !transition.events.empty() || element.Find("cond") != nullptr;
    if (is_default && (has_condition || element.Find("target") == nullptr)) {
      Say(element.line, "a default transition with event or cond, or without target", "it is always taken",
          "write <transition target=\"...\"/>");
    }
    if (!is_default && !has_condition && element.Find("target") == nullptr) {
      Say(element.line, "a transition without event, cond and target", "it would be taken for ever",
          "say when it is taken, or where it leads");
    }
    transition.actions = ReadActions(element);
    chart_.transitions.push_back(std::move(transition));
    return static_cast<int>(chart_.transitions.size() - 1);
  }

  void CheckDoneEvent(const XmlElement& element, const std::string& event) {
    constexpr std::string_view kDone = "done.state.";
    if (event.compare(0, kDone.size(), kDone) != 0 || chart_.Find(event.substr(kDone.size())) >= 0) return;
    Say(element.LineOf("event"), "event '" + event + "': no state '" + event.substr(kDone.size()) + "'",
        "done.state.ID tells that the state ID has reached its final",
        scene::SuggestName(event.substr(kDone.size()), Ids()));
  }

  [[nodiscard]] std::vector<std::string> Ids() const {
    std::vector<std::string> ids;
    for (const State& state : chart_.states) {
      if (!state.id.empty()) ids.push_back(state.id);
    }
    return ids;
  }

  std::vector<int> Targets(const std::string& text, int line) {
    std::vector<int> targets;
    for (const std::string& id : Words(text)) {
      const int state = chart_.Find(id);
      if (state < 0) {
        Say(line, "unknown target '" + id + "'", "it must be the id of a state in this file",
            scene::SuggestName(id, Ids()));
        continue;
      }
      for (const int other : targets) CheckBothActive(other, state, line);
      targets.push_back(state);
    }
    return targets;
  }

  // Several targets must be in different regions of one parallel state, or they could not be active together.
  void CheckBothActive(int a, int b, int line) {
    int ancestor = a;
    while (ancestor > 0 && !chart_.IsDescendant(b, ancestor)) ancestor = chart_.At(ancestor).parent;
    if (chart_.At(ancestor).kind == StateKind::kParallel && ancestor != a && ancestor != b) return;
    Say(line, "targets '" + chart_.At(a).id + "' and '" + chart_.At(b).id + "' cannot be active together",
        "they are not in different regions of a <parallel>", "name one target, or one per region");
  }

  std::vector<Action> ReadActions(const XmlElement& element) {
    std::vector<Action> actions;
    for (const XmlElement& child : element.children) {
      if (const auto action = ReadAction(child)) actions.push_back(*action);
    }
    return actions;
  }

  std::string Required(const XmlElement& element, const char* attribute) {
    const std::string value = element.Get(attribute);
    if (value.empty()) {
      Say(element.line, "<" + TagOf(element) + ">: " + attribute + " is missing", "it has no effect without",
          "add " + std::string(attribute) + "=\"...\"");
    }
    return value;
  }

  std::optional<Action> ReadAction(const XmlElement& element) {
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
        Say(element.line, "<" + tag + "> is no executable content", "actions only stand here",
            "move it into a <state>");
      }
      return std::nullopt;
    }
    return action;
  }

  void ReadSend(const XmlElement& element, Action* action) {
    action->kind = ActionKind::kSend;
    action->text = Required(element, "event");
    action->send_id = element.Get("id");
    const std::string target = element.Get("target");
    action->is_internal = target == "#_internal";
    if (!target.empty() && !action->is_internal) {
      Say(element.LineOf("target"), "<send>: target '" + target + "'", "events go to the chart itself",
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
      Say(element.LineOf("delay"), "<send>: delay is '" + delay + "'", "it is a time of 0 or more",
          "write \"3s\" or \"200ms\"");
      return;
    }
    if (action->is_internal) {
      Say(element.LineOf("delay"), "<send>: delay on an internal event", "internal events are for the same step",
          "remove delay or target");
    }
    action->delay_ns = static_cast<std::int64_t>(amount * (is_ms ? 1e6 : 1e9) + 0.5);
  }

  void ReadAssign(const XmlElement& element, Action* action) {
    action->kind = ActionKind::kAssign;
    const std::string location = Required(element, "location");
    const auto it = variables_.find(location);
    std::vector<std::string> names;
    for (const auto& [name, index] : variables_) names.push_back(name);
    if (it == variables_.end()) {
      if (!location.empty()) {
        Say(element.LineOf("location"), "<assign>: unknown location '" + location + "'",
            "it must be the id of a <data>", scene::SuggestName(location, names));
      }
      return;
    }
    action->index = it->second;
    const Type type = chart_.variables[static_cast<std::size_t>(it->second)].initial.type();
    action->value = Compile(element, "expr", true, type == Type::kTruth ? Type::kTruth : Type::kNumber);
  }

  void ReadIf(const XmlElement& element, Action* action) {
    action->kind = ActionKind::kIf;
    action->branches.push_back({Compile(element, "cond", true, Type::kTruth), {}});
    bool has_else = false;
    for (const XmlElement& child : element.children) {
      if (child.name == "elseif" || child.name == "else") {
        if (has_else) {
          Say(child.line, "<" + child.name + "> after <else>", "<else> is the last branch", "move it before <else>");
        }
        has_else = child.name == "else";
        action->branches.push_back({has_else ? Expression() : Compile(child, "cond", true, Type::kTruth), {}});
      } else if (const auto inner = ReadAction(child)) {
        action->branches.back().actions.push_back(*inner);
      }
    }
  }

  void ReadSet(const XmlElement& element, Action* action) {
    action->kind = ActionKind::kSetParameter;
    action->text = Required(element, "name");
    if (!action->text.empty() && (!vocabulary_.is_parameter || !vocabulary_.is_parameter(action->text))) {
      Say(element.LineOf("name"), "<vr:set>: unknown parameter '" + action->text + "'",
          "no node has a parameter of that name in this scenario",
          vocabulary_.suggest_parameter ? vocabulary_.suggest_parameter(action->text) : "correct the name");
    }
    action->value = Compile(element, "value", true, Type::kNumber);
  }

  void ReadLamp(const XmlElement& element, Action* action) {
    action->kind = ActionKind::kLamp;
    const std::string object = Required(element, "object");
    const auto lamp = vocabulary_.find_lamp ? vocabulary_.find_lamp(object) : std::nullopt;
    if (lamp) {
      action->index = *lamp;
    } else if (!object.empty()) {
      Say(element.LineOf("object"), "<vr:lamp>: '" + object + "' is no lamp", "it must be an <object> with a <lamp>",
          vocabulary_.suggest_lamp ? vocabulary_.suggest_lamp(object) : "correct the name");
    }
    std::vector<double> color;
    if (!scene::ParseNumbers(element.Get("color"), &color) || color.size() != 3 ||
        std::any_of(color.begin(), color.end(), [](double part) { return part < 0.0 || part > 1.0; })) {
      Say(element.LineOf("color"), "<vr:lamp>: color is '" + element.Get("color") + "'",
          "it is red, green and blue from 0 to 1", "write for example \"0 1 0\"");
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) action->color[i] = static_cast<float>(color[i]);
  }

  const Vocabulary& vocabulary_;
  Scope scope_;
  Chart chart_;
  std::vector<const XmlElement*> elements_;  // by state
  std::map<std::string, int> variables_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace

tl::expected<Chart, std::vector<scene::Diagnostic>> LoadChart(const std::filesystem::path& file,
                                                              const Vocabulary& vocabulary) {
  return Loader(file, vocabulary).Run();
}

}  // namespace logic_node::scxml
