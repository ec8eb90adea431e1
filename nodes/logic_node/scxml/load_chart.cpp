#include "nodes/logic_node/scxml/load_chart.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "core/names.hpp"
#include "nodes/logic_node/scxml/read_actions.hpp"
#include "scene/schema.hpp"
#include "scene/xml.hpp"

namespace logic_node::scxml {
namespace {

using scene::Diagnostic;
using scene::XmlElement;

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

class Loader {
 public:
  Loader(const std::filesystem::path& file, const Vocabulary& vocabulary)
      : actions_(vocabulary, &chart_, &diagnostics_) {
    chart_.file = file;
  }

  tl::expected<Chart, std::vector<Diagnostic>> Run() {
    const auto root = scene::ReadXml(chart_.file);
    if (!root) return tl::unexpected(root.error());
    if (root->name != "scxml" || root->name_space != kScxmlNamespace) {
      Report(root->line, "the root element is <" + root->name + ">", "a procedure is an SCXML document",
             "start with <scxml xmlns=\"" + std::string(kScxmlNamespace) + "\" xmlns:vr=\"" + kProcedureNamespace +
                 "\" version=\"1.0\">");
      return tl::unexpected(std::move(diagnostics_));
    }
    CheckElements(*root);
    AddStates(*root, -1);  // all ids first, since targets and In() may refer to later states
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
  void Report(int line, std::string what, std::string why, std::string fix) {
    actions_.Report(line, std::move(what), std::move(why), std::move(fix));
  }

  // Refuses elements and attributes that the interpreter does not implement; they would silently have no effect.
  void CheckElements(const XmlElement& element) {
    static const std::map<std::string, std::string> kRefused{
        {"script", "procedures run no scripts, so that every run is reproducible"},
        {"invoke", "procedures start no other services"},
        {"foreach", "variables of a procedure are single numbers"},
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
        Report(element.line, "<" + tag + "> is not supported", refused->second,
               "express it with states, transitions, <assign>, <send> and <vr:set>");
        return;
      }
      std::vector<std::string> tags;
      for (const auto& [name, attributes] : KnownAttributes()) tags.push_back(name);
      Report(element.line, "unknown element <" + tag + ">",
             is_known_space
                 ? "it is not in the SCXML subset for procedures"
                 : "its namespace '" + element.name_space + "' is neither SCXML's nor " + kProcedureNamespace,
             is_known_space ? core::SuggestName(tag, tags) : "correct xmlns or the prefix");
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
      Report(attribute.line, "<" + tag + ">: unknown attribute '" + prefix + attribute.name + "'",
             "it is not in the SCXML subset for procedures", core::SuggestName(attribute.name, names));
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
        Report(element.LineOf("id"), "a second state '" + state.id + "'",
               "the id is taken by line " + std::to_string(chart_.At(other).line), "rename one of them");
      }
      if (state.id.find_first_of(" \t\n") != std::string::npos) {
        Report(element.LineOf("id"), "the id '" + state.id + "' contains a blank", "blanks separate ids in lists",
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
        Report(child.line, "<" + child.name + "> inside <" + element.name + ">", "SCXML does not allow it there",
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
          if (data.name == "data") actions_.ReadVariable(data);
        }
      } else {
        ReadData(child);
      }
    }
  }

  void ReadState(int index, const XmlElement& element) {
    if (chart_.At(index).kind == StateKind::kHistory) {
      ReadHistory(index, element);
      return;
    }
    int num_initial_elements = 0;
    for (const XmlElement& child : element.children) {
      if (child.name == "onentry")
        Append(actions_.ReadActions(child), &chart_.states[static_cast<std::size_t>(index)].on_entry);
      if (child.name == "onexit")
        Append(actions_.ReadActions(child), &chart_.states[static_cast<std::size_t>(index)].on_exit);
      if (child.name == "initial") {
        ++num_initial_elements;
        ReadInitialElement(index, child);
      }
      if (child.name == "transition") {
        if (chart_.At(index).kind == StateKind::kScxml || chart_.At(index).kind == StateKind::kFinal) {
          Report(child.line, "<transition> inside <" + element.name + ">", "only states have transitions",
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
      Report(element.line, "<initial> without a transition", "it needs exactly one, to the initial state",
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
      Report(attribute->line, "initial given twice", "the attribute and the element have the same meaning",
             "remove one of them");
      return;
    }
    if (attribute != nullptr) {
      state.initial = Targets(attribute->value, attribute->line);
      CheckInside(index, state.initial, attribute->line, "initial");
    }
    if (state.kind == StateKind::kScxml && state.children.empty()) {
      Report(element.line, "<scxml> without states", "a chart needs at least one", "add a <state>");
    } else if (state.is_compound() && state.initial.empty() && num_initial_elements == 0) {
      state.initial = {state.children.front()};
    }
  }

  void CheckInside(int index, const std::vector<int>& targets, int line, const std::string& title) {
    for (const int target : targets) {
      if (chart_.IsDescendant(target, index)) continue;
      Report(line, title + ": '" + chart_.At(target).id + "' is not inside the state",
             "the initial state must be a descendant", "name a state inside '" + chart_.At(index).id + "'");
    }
  }

  void ReadHistory(int index, const XmlElement& element) {
    if (const std::string type = element.Get("type", "shallow"); type != "shallow") {
      Report(element.LineOf("type"), "history of type '" + type + "'", "only shallow histories are supported",
             "write type=\"shallow\", or one history per level");
    }
    std::vector<const XmlElement*> transitions;
    for (const XmlElement& child : element.children) {
      if (child.name == "transition") transitions.push_back(&child);
    }
    if (transitions.size() != 1) {
      Report(element.line,
             "history '" + chart_.At(index).id + "' with " + std::to_string(transitions.size()) + " transitions",
             "it needs one as its default", "add <transition target=\"...\"/>");
      return;
    }
    const int transition = ReadTransition(index, *transitions[0], true);
    CheckInside(chart_.At(index).parent, chart_.transitions[static_cast<std::size_t>(transition)].targets,
                transitions[0]->line, "history");
    chart_.states[static_cast<std::size_t>(index)].transitions.push_back(transition);
  }

  // A default transition (of <initial> and <history>) has a target, but neither event nor condition.
  int ReadTransition(int source, const XmlElement& element, bool is_default) {
    Transition transition;
    transition.source = source;
    transition.line = element.line;
    for (std::string event : Words(element.Get("event"))) {
      if (event.size() > 2 && event.ends_with(".*")) event.resize(event.size() - 2);
      CheckDoneEvent(element, event);
      transition.events.push_back(std::move(event));
    }
    transition.condition = actions_.Compile(element, "cond", false, Type::kBoolean);
    transition.targets = Targets(element.Get("target"), element.LineOf("target"));
    const std::string type = element.Get("type", "external");
    if (type != "internal" && type != "external") {
      Report(element.LineOf("type"), "transition of type '" + type + "'", "it is internal or external",
             "write one of them");
    }
    transition.is_internal = type == "internal";
    if (const scene::XmlAttribute* completes = element.Find("completes", kProcedureNamespace)) {
      if (!scene::ParseBoolean(completes->value, &transition.is_completing)) {
        Report(completes->line, "vr:completes is '" + completes->value + "'", "it is true or false", "write \"true\"");
      }
    }
    const bool has_condition = !transition.events.empty() || element.Find("cond") != nullptr;
    if (is_default && (has_condition || element.Find("target") == nullptr)) {
      Report(element.line, "a default transition with event or cond, or without target", "it is always taken",
             "write <transition target=\"...\"/>");
    }
    if (!is_default && !has_condition && element.Find("target") == nullptr) {
      Report(element.line, "a transition without event, cond and target", "it would be taken endlessly",
             "add an event, a condition or a target");
    }
    transition.actions = actions_.ReadActions(element);
    chart_.transitions.push_back(std::move(transition));
    return static_cast<int>(chart_.transitions.size() - 1);
  }

  void CheckDoneEvent(const XmlElement& element, const std::string& event) {
    constexpr std::string_view kDone = "done.state.";
    if (event.compare(0, kDone.size(), kDone) != 0 || chart_.Find(event.substr(kDone.size())) >= 0) return;
    Report(element.LineOf("event"), "event '" + event + "': no state '" + event.substr(kDone.size()) + "'",
           "done.state.ID is raised when the state ID reaches its final state",
           core::SuggestName(event.substr(kDone.size()), Ids()));
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
        Report(line, "unknown target '" + id + "'", "it must be the id of a state in this file",
               core::SuggestName(id, Ids()));
        continue;
      }
      for (const int other : targets) CheckBothActive(other, state, line);
      targets.push_back(state);
    }
    return targets;
  }

  // Several targets must be in different regions of one parallel state, else they cannot be active together.
  void CheckBothActive(int a, int b, int line) {
    int ancestor = a;
    while (ancestor > 0 && !chart_.IsDescendant(b, ancestor)) ancestor = chart_.At(ancestor).parent;
    if (chart_.At(ancestor).kind == StateKind::kParallel && ancestor != a && ancestor != b) return;
    Report(line, "targets '" + chart_.At(a).id + "' and '" + chart_.At(b).id + "' cannot be active together",
           "they are not in different regions of a <parallel>", "name one target, or one per region");
  }

  Chart chart_;
  std::vector<const XmlElement*> elements_;  // by state
  std::vector<Diagnostic> diagnostics_;
  ActionReader actions_;
};

}  // namespace

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
      {"vr:set", {"name", "value", "over_s", "when"}},
      {"vr:lamp", {"object", "color"}},
      {"vr:hint", {"text"}},
  };
  return known;
}

tl::expected<Chart, std::vector<scene::Diagnostic>> LoadChart(const std::filesystem::path& file,
                                                              const Vocabulary& vocabulary) {
  return Loader(file, vocabulary).Run();
}

}  // namespace logic_node::scxml
