#pragma once

#include <cstdint>
#include <string_view>

#include "bus/topic_table.hpp"
#include "core/hash.hpp"

namespace bus {

// '*' in the pattern matches any text, also none. Patterns come from other processes: only the last star is
// retried, so the time is at most the product of the lengths.
constexpr bool MatchesPattern(std::string_view pattern, std::string_view text) {
  std::size_t p = 0, t = 0;
  std::size_t star = std::string_view::npos, after_star = 0;  // the last star, and the text that it does not cover
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after_star = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after_star;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

// Null when no rule matches.
constexpr const TopicRule* FindTopicRule(std::string_view topic) {
  for (const TopicRule& rule : kTopicRules) {
    if (MatchesPattern(rule.pattern, topic)) return &rule;
  }
  return nullptr;
}

// Topic id on the wire: a hash of the name, so that no central numbering is needed. The registry refuses collisions.
inline std::uint32_t TopicId(std::string_view topic) {
  return static_cast<std::uint32_t>(core::Hash64(topic));
}

}  // namespace bus
