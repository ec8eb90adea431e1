#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nodes/logic_node/scxml/load_chart.hpp"
#include "scene/xml.hpp"

namespace logic_node::scxml {

// The part of LoadChart that reads expressions and executable content. States must be in the chart already, since In()
// and diagnostics refer to them; likewise data before the expressions that use them.
class ActionReader {
 public:
  // All three must outlive the reader, which appends errors to `diagnostics`.
  ActionReader(const Vocabulary& vocabulary, Chart* chart, std::vector<scene::Diagnostic>* diagnostics);

  void Report(int line, std::string what, std::string why, std::string fix);
  void ReadVariable(const scene::XmlElement& data);
  // Compiles an attribute. Absent: an empty expression, and a diagnostic if it is required.
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

// Name of an element as written in procedures, with "vr:" for the project's own namespace.
std::string TagOf(const scene::XmlElement& element);

// Attributes of each element of the subset, by tag.
const std::map<std::string, std::vector<std::string>>& KnownAttributes();

}  // namespace logic_node::scxml
