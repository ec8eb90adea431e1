#include "scene/schema.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "core/names.hpp"
#include "space/instant.hpp"

namespace scene {
namespace {

const ElementRule* FindRule(const std::vector<ElementRule>& rules, const std::string& name) {
  for (const ElementRule& rule : rules) {
    if (rule.name == name) return &rule;
  }
  return nullptr;
}

std::vector<std::string_view> SplitBlanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<std::string_view> words;
  std::size_t at = text.find_first_not_of(kBlanks);
  while (at != std::string_view::npos) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kBlanks, end);
  }
  return words;
}

bool IsColor(const std::string& text) {
  std::vector<double> values;
  return ParseNumbers(text, &values) && values.size() == 3 &&
         std::all_of(values.begin(), values.end(), [](double value) { return value >= 0.0 && value <= 1.0; });
}

bool IsName(const std::string& text) {
  return !text.empty() && text.find_first_of(" \t\r\n") == std::string::npos && text.front() != '/' &&
         text.back() != '/';
}

// Empty when the text is valid for the rule; else what the rule requires.
std::string FindViolation(const AttributeRule& rule, const std::string& text) {
  double number = 0.0;
  std::uint64_t count = 0;
  bool truth = false;
  std::vector<double> numbers;
  switch (rule.kind) {
    case ValueKind::kText:
      return {};
    case ValueKind::kName:
      return IsName(text) ? "" : "a name without blanks";
    case ValueKind::kFile:
      return !text.empty() ? "" : "a path relative to the scenario's folder";
    case ValueKind::kNumber:
      return ParseNumber(text, &number) ? "" : "a finite number";
    case ValueKind::kNonNegative:
      return ParseNumber(text, &number) && number >= 0.0 ? "" : "a finite number, zero or above";
    case ValueKind::kPositive:
      return ParseNumber(text, &number) && number > 0.0 ? "" : "a finite number above zero";
    case ValueKind::kShare:
      return ParseNumber(text, &number) && number > 0.0 && number < 1.0 ? "" : "a number above 0 and below 1";
    case ValueKind::kCount:
      return ParseCount(text, &count) ? "" : "a whole number, zero or above";
    case ValueKind::kBoolean:
      return ParseBoolean(text, &truth) ? "" : "true or false";
    case ValueKind::kVector:
      return ParseNumbers(text, &numbers) && numbers.size() == 3 ? "" : "three finite numbers separated by blanks";
    case ValueKind::kColor:
      return IsColor(text) ? "" : "three numbers from 0 to 1 separated by blanks";
    case ValueKind::kNumbers:
      return ParseNumbers(text, &numbers) ? "" : "finite numbers separated by blanks";
    case ValueKind::kInstant:
      return space::ParseInstant(text) ? "" : "a moment in UTC from 1972 to 2099 such as 2016-03-05T12:00:00Z";
    case ValueKind::kChoice:
      return std::find(rule.choices.begin(), rule.choices.end(), text) != rule.choices.end()
                 ? ""
                 : "one of " + core::ListNames(rule.choices);
  }
  return {};
}

// Name of an element in messages: "object 'block'" or "<coupling>".
std::string Title(const XmlElement& element) {
  for (const char* key : {"name", "role"}) {
    if (const XmlAttribute* attribute = element.Find(key)) return element.name + " '" + attribute->value + "'";
  }
  return "<" + element.name + ">";
}

class SchemaChecker {
 public:
  SchemaChecker(const std::vector<ElementRule>& rules, const std::filesystem::path& file,
                std::vector<Diagnostic>* diagnostics)
      : rules_(rules), file_(file), diagnostics_(diagnostics) {}

  void Check(const XmlElement& element, const ElementRule& rule) {
    CheckAttributes(element, rule);
    CheckChildren(element, rule);
    if (!element.text.empty()) {
      Report(element.line, Title(element) + " contains the text '" + element.text.substr(0, 40) + "'",
             "the format has attributes and elements only", "remove the text or make it a comment <!-- ... -->");
    }
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({{file_, line}, std::move(what), std::move(why), std::move(fix)});
  }

  void CheckAttributes(const XmlElement& element, const ElementRule& rule) {
    std::vector<std::string> known;
    for (const AttributeRule& attribute : rule.attributes) known.push_back(attribute.name);
    for (const XmlAttribute& attribute : element.attributes) {
      if (attribute.name_space == "http://www.w3.org/2001/XMLSchema-instance")
        continue;  // the XSD's location, for editors
      const auto it = std::find_if(rule.attributes.begin(), rule.attributes.end(),
                                   [&](const AttributeRule& candidate) { return candidate.name == attribute.name; });
      if (it == rule.attributes.end()) {
        const auto gone = std::find_if(rule.gone.begin(), rule.gone.end(), [&](const GoneAttribute& candidate) {
          return candidate.name == attribute.name;
        });
        if (gone != rule.gone.end()) {
          Report(attribute.line, Title(element) + ": attribute '" + attribute.name + "'",
                 "<" + rule.name + "> no longer has it", gone->fix);
          continue;
        }
        Report(attribute.line, Title(element) + ": unknown attribute '" + attribute.name + "'",
               "<" + rule.name + "> does not have it", core::SuggestName(attribute.name, known));
        continue;
      }
      const std::string violation = FindViolation(*it, attribute.value);
      if (!violation.empty()) {
        Report(attribute.line, Title(element) + ": " + attribute.name + " is '" + attribute.value + "'",
               "it must be " + violation, "write " + violation + " in " + attribute.name);
      }
    }
    for (const AttributeRule& attribute : rule.attributes) {
      if (attribute.is_required && element.Find(attribute.name) == nullptr) {
        Report(element.line, Title(element) + ": attribute '" + attribute.name + "' is missing",
               "<" + rule.name + "> needs it: " + rule.meaning, "add " + attribute.name + "=\"...\"");
      }
    }
  }

  void CheckChildren(const XmlElement& element, const ElementRule& rule) {
    std::vector<std::string> known;
    for (const ChildRule& child : rule.children) known.push_back(child.name);
    std::map<std::string, std::size_t> counts;
    for (const XmlElement& child : element.children) {
      const auto it = std::find_if(rule.children.begin(), rule.children.end(),
                                   [&](const ChildRule& candidate) { return candidate.name == child.name; });
      if (it == rule.children.end()) {
        Report(child.line, "unknown element <" + child.name + "> in " + Title(element),
               "<" + rule.name + "> cannot contain it", core::SuggestName(child.name, known));
        continue;
      }
      if (it->max_count > 0 && ++counts[child.name] > it->max_count) {
        Report(child.line, "a second <" + child.name + "> in " + Title(element), "there can be only one", "remove one");
      }
      Check(child, *FindRule(rules_, child.name));
    }
    for (const ChildRule& child : rule.children) {
      const auto count = std::count_if(element.children.begin(), element.children.end(),
                                       [&](const XmlElement& candidate) { return candidate.name == child.name; });
      if (static_cast<std::size_t>(count) < child.min_count) {
        Report(element.line, "<" + child.name + "> is missing in " + Title(element),
               "it is required: " + FindRule(rules_, child.name)->meaning, "add a <" + child.name + ">");
      }
    }
  }

  const std::vector<ElementRule>& rules_;
  const std::filesystem::path& file_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

void CheckAgainstRules(const XmlElement& root, const std::filesystem::path& file, std::vector<Diagnostic>* diagnostics,
                       const std::string& root_name, const std::vector<ElementRule>& rules) {
  if (root.name != root_name) {
    diagnostics->push_back({{file, root.line},
                            "the root element is <" + root.name + ">",
                            "it must be <" + root_name + ">",
                            "put the content into <" + root_name + ">"});
    return;
  }
  SchemaChecker(rules, file, diagnostics).Check(root, *FindRule(rules, root_name));
}

bool ParseNumber(const std::string& text, double* value) {
  std::vector<double> values;
  if (!ParseNumbers(text, &values) || values.size() != 1) return false;
  *value = values[0];
  return true;
}

bool ParseCount(const std::string& text, std::uint64_t* value) {
  const std::vector<std::string_view> words = SplitBlanks(text);
  if (words.size() != 1) return false;
  std::uint64_t parsed = 0;
  const auto [end, error] = std::from_chars(words[0].data(), words[0].data() + words[0].size(), parsed);
  if (error != std::errc() || end != words[0].data() + words[0].size()) return false;
  *value = parsed;
  return true;
}

bool ParseNumbers(const std::string& text, std::vector<double>* values) {
  std::vector<double> parsed;
  for (std::string_view word : SplitBlanks(text)) {
    if (word.size() > 1 && word.front() == '+') word.remove_prefix(1);
    double number = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) return false;
    parsed.push_back(number);
  }
  *values = std::move(parsed);
  return true;
}

bool ParseBoolean(const std::string& text, bool* value) {
  if (text != "true" && text != "false" && text != "1" && text != "0") return false;
  *value = text == "true" || text == "1";
  return true;
}

}  // namespace scene
