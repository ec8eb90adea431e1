#include "replay/difference.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

#include "bus/topics.hpp"
#include "core/hash.hpp"

namespace replay {

void Digest::Text(std::string_view, std::string& text) {
  Add(core::Hash64(text));
}

void Leaves::Enter(std::string_view name) {
  lengths_.push_back(path_.size());
  if (!path_.empty() && !name.empty()) path_ += '.';
  path_ += name;
}

void Leaves::Enter(std::string_view name, std::size_t index) {
  Enter(name);
  path_ += '[' + std::to_string(index) + ']';
}

void Leaves::Leave() {
  path_.resize(lengths_.back());
  lengths_.pop_back();
}

std::string Leaves::PathOf(std::string_view name) const {
  if (name.empty()) return path_;
  return path_.empty() ? std::string(name) : path_ + '.' + std::string(name);
}

void Leaves::Text(std::string_view name, std::string& text) {
  leaves_.push_back(
      {PathOf(name), Leaf::Kind::kText, std::numeric_limits<double>::quiet_NaN(), core::Hash64(text), text});
}

std::size_t Leaves::Count(std::string_view name, std::size_t count) {
  leaves_.push_back(
      {PathOf(std::string(name) + ".size"), Leaf::Kind::kUnsigned, static_cast<double>(count), count, {}});
  return count;
}

core::Result<Tolerance> Tolerance::Read(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) return core::Fail(core::ErrorCode::kIo, file + ": cannot be read");
  std::stringstream text;
  text << stream.rdbuf();
  return Parse(text.str(), file);
}

core::Result<Tolerance> Tolerance::Parse(const std::string& text, const std::string& file) {
  Tolerance tolerance;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    Rule rule;
    if (!(words >> rule.pattern)) continue;
    bool says_something = false;
    std::string word;
    while (words >> word) {
      char* end = nullptr;
      const std::string value = word.size() > 4 ? word.substr(4) : "";
      const double figure = std::strtod(value.c_str(), &end);
      const bool is_figure = !value.empty() && *end == '\0' && figure >= 0.0;
      says_something = true;
      if (word == "ignore") {
        rule.is_ignored = true;
      } else if (word.starts_with("abs=") && is_figure) {
        rule.absolute = figure;
      } else if (word.starts_with("rel=") && is_figure) {
        rule.relative = figure;
      } else {
        return core::Fail(core::ErrorCode::kInvalidInput, file + ":" + std::to_string(number) + ": '" + word +
                                                              "' is not abs=NUMBER, rel=NUMBER or ignore");
      }
    }
    if (!says_something) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        file + ":" + std::to_string(number) + ": give abs=NUMBER, rel=NUMBER or ignore");
    }
    tolerance.rules_.push_back(rule);
  }
  return tolerance;
}

const Tolerance::Rule* Tolerance::Find(const std::string& name) const {
  for (const Rule& rule : rules_) {
    if (bus::MatchesPattern(rule.pattern, name)) return &rule;
  }
  return nullptr;
}

bool Tolerance::Ignores(const std::string& name) const {
  const Rule* rule = Find(name);
  return rule != nullptr && rule->is_ignored;
}

bool Tolerance::IsWithin(const std::string& name, const Leaf& expected, const Leaf& got) const {
  if (expected.bits == got.bits) return true;
  const Rule* rule = Find(name);
  if (rule == nullptr) return false;
  // In this form a NaN is never within.
  return rule->is_ignored ||
         std::abs(got.number - expected.number) <= rule->absolute + rule->relative * std::abs(expected.number);
}

std::string TextOf(const Leaf* leaf) {
  if (leaf == nullptr) return "nothing";
  char text[32];
  switch (leaf->kind) {
    case Leaf::Kind::kReal:
      std::snprintf(text, sizeof text, "%.17g", leaf->number);
      return text;
    case Leaf::Kind::kSigned:
      return std::to_string(static_cast<std::int64_t>(leaf->bits));
    case Leaf::Kind::kUnsigned:
      return std::to_string(leaf->bits);
    case Leaf::Kind::kText:
      break;
  }
  return "'" + leaf->text + "'";
}

FieldDifference DifferenceOf(const Leaf* expected, const Leaf* got) {
  const Leaf& named = expected != nullptr ? *expected : *got;
  FieldDifference difference{named.path, TextOf(expected), TextOf(got), std::numeric_limits<double>::infinity()};
  if (expected == nullptr || got == nullptr) return difference;
  const double distance = std::abs(got->number - expected->number);
  if (std::isfinite(distance)) difference.distance = distance;
  return difference;
}

}  // namespace replay
