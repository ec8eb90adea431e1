#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nodes/logic_node/scxml/load_chart.hpp"
#include "scene/xml.hpp"

namespace logic_node::scxml {

// The part of LoadChart that reads expressions and executable content. States must be in the chart before, since In()
// and messages refer to them; data before what uses them.
class ActionReader {
 public:
  // All three must outlive the reader; problems are appended to `diagnostics`.
  ActionReader(const Vocabulary& vocabulary, Chart* chart, std::vector<scene::Diagnostic>* diagnostics);

  void Say(int line, std::string what, std::string why, std::string fix);
  void ReadVariable(const scene::XmlElement& data);
  // Compiles an attribute. Absent: an empty expression, and a message when it is required.
  Expression Compile(const scene::XmlElement& element, const char* attribute, bool is_required,
                     std::optional<Type> wanted = std::nullopt);
  // Executable content directly inside the element.
  std::vector<Action> ReadActions(const scene::XmlElement& element);

 private:
  std::string Required(const scene::XmlElement& element, const char* attribute);
  std::optional<Action> ReadAction(const scene::XmlElement& element);
  void ReadSend(const scene::XmlElement& element, Action* action);
  void ReadAssign(const scene::XmlElement& element, Action* action);
  void ReadIf(const scene::XmlElement& element, Action* action);
  void ReadSet(const scene::XmlElement& element, Action* action);
  void ReadManner(const scene::XmlElement& element, Action* action);
  void ReadLamp(const scene::XmlElement& element, Action* action);

  const Vocabulary& vocabulary_;
  Chart& chart_;
  std::vector<scene::Diagnostic>& diagnostics_;
  Scope scope_;
  std::map<std::string, int> variables_;
};

// The element's name as procedures write it: "vr:" before those of the project's own namespace.
std::string TagOf(const scene::XmlElement& element);

// Attributes of each element of the subset, by tag.
const std::map<std::string, std::vector<std::string>>& KnownAttributes();

}  // namespace logic_node::scxml
