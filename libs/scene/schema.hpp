#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/xml.hpp"

namespace scene {

// The schema of scenario.xml. The loader checks files against this table, and WriteXsd() generates
// scenarios/scenario.xsd (for editors and xmllint) from it; a test compares the two.

enum class ValueKind {
  kText,
  kName,         // not empty; no blanks, no '/' at either end
  kFile,         // path relative to the scenario's folder
  kNumber,       // finite
  kNonNegative,  // finite, >= 0
  kPositive,     // finite, > 0
  kShare,        // > 0 and < 1
  kCount,        // integer >= 0
  kBoolean,      // true | false | 1 | 0
  kVector,       // three finite numbers
  kColor,        // three numbers in [0, 1]
  kNumbers,      // any number of finite numbers
  kInstant,      // UTC, such as 2016-03-05T12:00:00Z
  kChoice,       // one of `choices`
};

struct AttributeRule {
  std::string name;
  ValueKind kind = ValueKind::kText;
  bool is_required = false;
  std::vector<std::string> choices;
};

struct ChildRule {
  std::string name;
  std::size_t min_count = 0;
  std::size_t max_count = 0;  // 0: any number
};

// An attribute of older files, and what to write instead.
struct GoneAttribute {
  std::string name;
  std::string fix;
};

struct ElementRule {
  std::string name;
  std::string meaning;
  std::vector<AttributeRule> attributes;
  std::vector<ChildRule> children;
  std::vector<GoneAttribute> gone = {};
};

// Rules of every element; the first is the root.
const std::vector<ElementRule>& ScenarioRules();

// Checks elements, attributes and values against the rules: everything that concerns one element alone. `root_name` is
// the required root element.
void CheckAgainstRules(const XmlElement& root, const std::filesystem::path& file, std::vector<Diagnostic>* diagnostics,
                       const std::string& root_name = "scenario",
                       const std::vector<ElementRule>& rules = ScenarioRules());

// The text of the XML Schema (XSD 1.0) generated from ScenarioRules().
std::string WriteXsd();

// Parse an attribute's text. On malformed text they return false and leave *value unchanged.
bool ParseNumber(const std::string& text, double* value);
bool ParseCount(const std::string& text, std::uint64_t* value);
bool ParseNumbers(const std::string& text, std::vector<double>* values);
bool ParseBoolean(const std::string& text, bool* value);

}  // namespace scene
