#include "nodes/device_bridge/operator/operator_script.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/names.hpp"
#include "scene/xml.hpp"

namespace device_bridge {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
const std::vector<std::string> kVerbs{"step", "role", "reach", "carry", "push", "grip", "wait"};
const std::vector<std::string> kConditions{"engaged", "free", "state", "held", "released"};

std::vector<std::string> SplitWords(std::string_view line) {
  std::vector<std::string> words;
  std::istringstream stream{std::string(line.substr(0, line.find('#')))};
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Reads the words of one line from left to right. Keeps the first error and ignores the rest of the line.
class LineReader {
 public:
  LineReader(const std::vector<std::string>& words, const scene::Scenario& scenario)
      : words_(words), scenario_(scenario) {}

  [[nodiscard]] bool at_end() const { return has_failed() || position_ >= words_.size(); }
  [[nodiscard]] bool has_failed() const { return !what_.empty(); }
  [[nodiscard]] const std::string& what() const { return what_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] const std::string& fix() const { return fix_; }

  void Fail(const std::string& what, const std::string& why, const std::string& fix) {
    if (has_failed()) return;
    what_ = what;
    why_ = why;
    fix_ = fix;
  }

  // Consumes `word` if it is the next one.
  bool Take(std::string_view word) {
    if (at_end() || words_[position_] != word) return false;
    ++position_;
    return true;
  }

  std::string Word(const std::string& meaning, const std::string& example) {
    if (has_failed()) return {};
    if (position_ >= words_.size()) {
      Fail(meaning + " is missing", "the line ends after '" + words_.back() + "'", "write e.g. '" + example + "'");
      return {};
    }
    return words_[position_++];
  }

  double Number(const std::string& meaning, double least, double greatest, const std::string& example) {
    const std::string word = Word(meaning, example);
    if (has_failed()) return 0.0;
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      Fail("'" + word + "' is not a number", meaning + " must be one", "write e.g. '" + example + "'");
    } else if (value < least || value > greatest) {
      std::ostringstream range;
      range << meaning << " must be from " << least << " to " << greatest;
      Fail(meaning + " is " + word, range.str(), "write e.g. '" + example + "'");
    }
    return value;
  }

  glm::dvec3 Vector(const std::string& meaning, double greatest, const std::string& example) {
    glm::dvec3 v;
    for (int i = 0; i < 3; ++i) v[i] = Number(meaning, -greatest, greatest, example);
    return v;
  }

  int Object(const std::string& name) {
    const int object = scenario_.FindObject(name);
    if (object < 0) {
      std::vector<std::string> names;
      for (const scene::Object& o : scenario_.objects) names.push_back(o.name);
      Fail("no object '" + name + "'", "the scenario has no object of that name", core::SuggestName(name, names));
    }
    return object;
  }

  FrameReference Frame(const std::string& example) {
    FrameReference reference;
    const std::string word = Word("a frame", example);
    if (has_failed()) return reference;
    if (word == "hand") {
      reference.is_hand = true;
      return reference;
    }
    // Object names may contain dots, so the frame's name follows the last one; the whole word may also be an object.
    reference.object = scenario_.FindObject(word);
    if (reference.object >= 0) return reference;
    const std::size_t dot = word.rfind('.');
    if (dot == std::string::npos) {
      reference.object = Object(word);
      return reference;
    }
    reference.object = Object(word.substr(0, dot));
    if (has_failed()) return reference;
    const std::string name = word.substr(dot + 1);
    std::vector<std::string> names;
    for (const scene::Frame& frame : scenario_.objects[static_cast<std::size_t>(reference.object)].frames) {
      if (frame.name == name) {
        reference.X_OF = frame.X_OF;
        return reference;
      }
      names.push_back(frame.name);
    }
    Fail("object '" + word.substr(0, dot) + "' has no frame '" + name + "'", "a frame must be named in scenario.xml",
         names.empty() ? "add <frame name=\"" + name + "\" .../> to the object" : core::SuggestName(name, names));
    return reference;
  }

  int Mechanism(const std::string& meaning, bool must_be_snap) {
    const std::string name = Word(meaning, "latch_a");
    if (has_failed()) return -1;
    const int mechanism = scenario_.FindMechanism(name);
    if (mechanism < 0) {
      std::vector<std::string> names;
      for (const scene::Mechanism& m : scenario_.mechanisms) names.push_back(m.name);
      Fail("no mechanism '" + name + "'", "the scenario has no mechanism of that name", core::SuggestName(name, names));
    } else if (must_be_snap &&
               scenario_.mechanisms[static_cast<std::size_t>(mechanism)].kind != scene::MechanismKind::kSnap) {
      Fail("'" + name + "' is not a snap", "only a snap can be engaged or free", "use 'state " + name + " N'");
    }
    return mechanism;
  }

  Condition ReadCondition() {
    Condition condition;
    const std::string word = Word("a condition", "engaged latch_a");
    if (has_failed()) return condition;
    if (word == "engaged" || word == "free") {
      condition.kind = word == "engaged" ? ConditionKind::kEngaged : ConditionKind::kFree;
      condition.mechanism = Mechanism("the snap", true);
    } else if (word == "state") {
      condition.kind = ConditionKind::kState;
      condition.mechanism = Mechanism("the mechanism", false);
      condition.state = static_cast<int>(Number("the state", 0, 1000, "state switch_a 1"));
    } else if (word == "held") {
      condition.kind = ConditionKind::kHeld;
      const std::string name = Word("the object", "held handle");
      if (!has_failed()) condition.object = Object(name);
    } else if (word == "released") {
      condition.kind = ConditionKind::kReleased;
    } else {
      Fail("no condition '" + word + "'", "a condition is " + core::ListNames(kConditions),
           core::SuggestName(word, kConditions));
    }
    return condition;
  }

  // Fails if words are left over.
  void ExpectEnd(const std::string& allowed) {
    if (!at_end()) Fail("unexpected '" + words_[position_] + "'", "allowed here: " + allowed, "remove it");
  }
  [[nodiscard]] std::string Next() const { return at_end() ? std::string() : words_[position_]; }

 private:
  const std::vector<std::string>& words_;
  const scene::Scenario& scenario_;
  std::size_t position_ = 1;
  std::string what_, why_, fix_;
};

// offset x y z | turn r p y | speed V | within D, in any order.
void ReadMotionOptions(LineReader& reader, OperatorLine* line) {
  while (!reader.at_end()) {
    if (reader.Take("offset")) {
      line->X_FG.translation = reader.Vector("the offset", 10.0, "offset 0 0 0.05");
    } else if (reader.Take("turn")) {
      line->X_FG.rotation =
          core::QuaternionFromRollPitchYaw(kRadiansPerDegree * reader.Vector("the turn", 360.0, "turn 0 0 90"));
    } else if (reader.Take("speed")) {
      line->speed_m_per_s = reader.Number("the speed", 0.001, 2.0, "speed 0.25");
    } else if (reader.Take("within")) {
      line->within_m = reader.Number("the tolerance", 0.0001, 0.5, "within 0.003");
    } else {
      reader.ExpectEnd("'offset x y z', 'turn r p y', 'speed V' and 'within D'");
      return;
    }
  }
}

void ReadPush(LineReader& reader, OperatorLine* line) {
  const glm::dvec3 direction = reader.Vector("the direction", 1e6, "push 0 0 -1 by 0.05");
  const double length = glm::length(direction);
  if (!reader.has_failed() && length < 1e-9) {
    reader.Fail("the direction is 0 0 0", "a push needs a direction", "write e.g. 'push 0 0 -1 by 0.05'");
  }
  if (!reader.Take("by")) {
    reader.Fail("'by' is missing", "a push needs its largest distance", "write e.g. 'push 0 0 -1 by 0.05'");
  }
  line->distance_m = reader.Number("the distance", 0.0001, 5.0, "by 0.05");
  line->speed_m_per_s = 0.05;
  while (!reader.at_end()) {
    if (reader.Take("speed")) {
      line->speed_m_per_s = reader.Number("the speed", 0.001, 2.0, "speed 0.05");
    } else if (reader.Take("until")) {
      if (reader.Take("felt")) {
        line->until_felt_N = reader.Number("the felt force", 0.1, 200.0, "until felt 12");
      } else {
        line->until = reader.ReadCondition();
      }
    } else {
      reader.ExpectEnd("'speed V', 'until felt N' and 'until CONDITION'");
    }
  }
  if (!reader.has_failed()) line->direction_W = direction / length;
}

void ReadLine(LineReader& reader, const std::string& verb, const scene::Scenario& scenario, OperatorLine* line) {
  if (verb == "reach") {
    line->verb = Verb::kReach;
    line->goal = reader.Frame("reach handle.grip");
    ReadMotionOptions(reader, line);
    if (!reader.has_failed() && line->goal.is_hand) {
      reader.Fail("'hand' cannot be reached", "it is the hand itself that moves", "name a frame of an object");
    }
  } else if (verb == "carry") {
    line->verb = Verb::kCarry;
    line->speed_m_per_s = 0.15;
    line->within_m = 0.002;
    line->moved = reader.Frame("carry handle.tip to module.socket");
    if (!reader.Take("to")) {
      reader.Fail("'to' is missing", "carry moves one frame to another",
                  "write e.g. 'carry handle.tip to module.socket'");
    }
    line->goal = reader.Frame("carry handle.tip to module.socket");
    ReadMotionOptions(reader, line);
    if (!reader.has_failed() && line->goal.is_hand) {
      reader.Fail("'hand' cannot be carried to", "it is the hand itself that moves", "name a frame of an object");
    }
  } else if (verb == "push") {
    line->verb = Verb::kPush;
    ReadPush(reader, line);
  } else if (verb == "grip") {
    line->verb = Verb::kGrip;
    const scene::Device& device = scenario.devices[static_cast<std::size_t>(line->role)];
    // Fingers, unlike jaws, close beyond each other, and so press harder on what is between them.
    const double least = device.jaw_left < 0 ? -device.opening_max_m : 0.0;
    line->opening_m = reader.Number("the opening", least, device.opening_max_m, "grip 0.02 force 20");
    if (reader.Take("force")) line->grip_strength_N = reader.Number("the strength", 0.1, 200.0, "force 20");
    if (reader.Take("friction")) line->grip_friction = reader.Number("the friction", 0.01, 2.0, "friction 0.4");
    reader.ExpectEnd("'force N', 'friction MU'");
  } else {
    line->verb = Verb::kWait;
    if (reader.Take("until")) {
      line->until = reader.ReadCondition();
    } else {
      line->seconds = reader.Number("the time", 0.0, 600.0, "wait 0.5");
    }
    reader.ExpectEnd("'wait SECONDS' or 'wait until CONDITION'");
  }
}

}  // namespace

ParsedOperatorScript ParseOperatorScript(std::string_view text, const std::filesystem::path& file,
                                         const scene::Scenario& scenario, const std::vector<std::string>& step_names) {
  ParsedOperatorScript parsed;
  parsed.script.file = file;
  const auto report = [&](int line, const std::string& what, const std::string& why, const std::string& fix) {
    parsed.diagnostics.push_back({{file, line}, what, why, fix});
  };
  std::vector<std::string> roles;
  for (const scene::Device& device : scenario.devices) roles.push_back(device.role);
  int role = scenario.devices.size() == 1 ? 0 : -1;

  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::vector<std::string> words = SplitWords(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (words.empty()) continue;
    const std::string& verb = words[0];
    if (std::find(kVerbs.begin(), kVerbs.end(), verb) == kVerbs.end()) {
      report(number, "no command '" + verb + "'", "a line starts with " + core::ListNames(kVerbs),
             core::SuggestName(verb, kVerbs));
      continue;
    }
    LineReader reader(words, scenario);
    if (verb == "step") {
      const std::string name = reader.Word("the step's name", "step insert_new");
      reader.ExpectEnd("one name");
      if (!reader.has_failed()) {
        const auto same = [&](const OperatorStep& step) { return step.name == name; };
        const auto before = std::find_if(parsed.script.steps.begin(), parsed.script.steps.end(), same);
        if (before != parsed.script.steps.end()) {
          reader.Fail("step '" + name + "' is defined twice", "the first is in line " + std::to_string(before->line),
                      "put all lines of a step together");
        } else if (!step_names.empty() && std::find(step_names.begin(), step_names.end(), name) == step_names.end()) {
          reader.Fail("no step '" + name + "'", "the procedure has no step of that name",
                      core::SuggestName(name, step_names));
        }
      }
      parsed.script.steps.push_back({name, number, {}});  // even a wrong one, so that its lines are checked too
    } else if (verb == "role") {
      const std::string name = reader.Word("the role's name", "role right");
      reader.ExpectEnd("one name");
      if (!reader.has_failed()) {
        const int found = scenario.FindRole(name);
        if (found < 0) {
          reader.Fail("no role '" + name + "'", "no device has that role", core::SuggestName(name, roles));
        } else {
          role = found;
        }
      }
    } else if (role < 0) {
      reader.Fail(
          "the role is missing", "the scenario has " + std::to_string(roles.size()) + " devices",
          roles.empty() ? "add a <device> to the scenario" : "write 'role NAME' above; " + core::ListNames(roles));
    } else if (parsed.script.steps.empty()) {
      reader.Fail("'" + verb + "' stands before the first step", "every line belongs to a step",
                  "write 'step NAME' above it");
    } else {
      OperatorLine line;
      line.role = role;
      line.line = number;
      ReadLine(reader, verb, scenario, &line);
      if (!reader.has_failed()) parsed.script.steps.back().lines.push_back(line);
    }
    if (reader.has_failed()) report(number, reader.what(), reader.why(), reader.fix());
  }
  return parsed;
}

std::vector<std::string> ReadStepNames(const std::filesystem::path& procedure) {
  std::vector<std::string> names;
  const auto root = scene::ReadXml(procedure);
  if (!root) return names;
  std::vector<const scene::XmlElement*> open{&*root};
  while (!open.empty()) {
    const scene::XmlElement* element = open.back();
    open.pop_back();
    for (const scene::XmlElement& child : element->children) open.push_back(&child);
    if (element->Get("id") != "procedure") continue;
    for (const scene::XmlElement& child : element->children) {
      if ((child.name == "state" || child.name == "parallel") && !child.Get("id").empty())
        names.push_back(child.Get("id"));
    }
  }
  return names;
}

namespace {

ParsedOperatorScript ReadScript(const scene::Scenario& scenario) {
  if (scenario.operator_script.empty()) return {};
  std::ifstream stream(scenario.operator_script, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) {
    ParsedOperatorScript parsed;
    parsed.diagnostics.push_back({{scenario.operator_script, 0},
                                  "the operator script cannot be read",
                                  "scenario.xml names it in <operator file=.../>",
                                  "create the file or correct its name"});
    return parsed;
  }
  return ParseOperatorScript(text.str(), scenario.operator_script, scenario, ReadStepNames(scenario.procedure));
}

}  // namespace

core::Result<OperatorScript> LoadOperatorScript(const scene::Scenario& scenario) {
  ParsedOperatorScript parsed = ReadScript(scenario);
  if (parsed.diagnostics.empty()) return std::move(parsed.script);
  std::string detail;
  for (const scene::Diagnostic& diagnostic : parsed.diagnostics) {
    if (!detail.empty()) detail += '\n';
    detail += scene::Format(diagnostic);
  }
  return core::Fail(core::ErrorCode::kInvalidInput, detail);
}

std::vector<scene::Diagnostic> CheckOperatorScript(const scene::Scenario& scenario) {
  return ReadScript(scenario).diagnostics;
}

}  // namespace device_bridge
