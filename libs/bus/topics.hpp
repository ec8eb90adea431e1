#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/hash.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "core/messages/sheet.hpp"

namespace bus {

// How a topic travels. The class belongs to the topic, never to an endpoint, so two ends cannot disagree.
// Values are on the wire: append, never renumber.
enum class TopicClass : std::uint8_t {
  kLatest = 1,   // UDP datagrams, newest wins, loss counted
  kState = 2,    // retained and keyed: subscribe, ack, snapshot, deltas
  kEvent = 3,    // ordered, acknowledged, drops counted and named
  kService = 4,  // correlation id and deadline
  kControl = 5,  // the bus itself: registry, heartbeats
  kBulk = 6,     // blocks of bytes by the hash of their content, in chunks; never beside EVENT
};

constexpr std::string_view NameOf(TopicClass topic_class) {
  switch (topic_class) {
    case TopicClass::kLatest:
      return "LATEST";
    case TopicClass::kState:
      return "STATE";
    case TopicClass::kEvent:
      return "EVENT";
    case TopicClass::kService:
      return "SERVICE";
    case TopicClass::kControl:
      return "CONTROL";
    case TopicClass::kBulk:
      return "BULK";
  }
  return "?";
}

// What a topic carries. Values are on the wire: append, never renumber.
enum class MessageType : std::uint8_t {
  kNone = 0,
  kDeviceState = 1,
  kDeviceCommand = 2,
  kHapticProxy = 3,
  kContactSet = 4,
  kPhysicsState = 5,
  kReaction = 6,
  kLogicStatus = 7,
  kFigures = 8,
  kEvent = 9,
  kParameterChange = 10,
  kSheetState = 11,
  kBulkOffer = 12,
};

constexpr MessageType kLastMessageType = MessageType::kBulkOffer;

struct TopicRule {
  std::string_view pattern;  // '*' stands for any text, slashes included (role and pair names may hold them)
  TopicClass topic_class;
  MessageType type;
  std::int64_t max_age_ns;  // older than this is stale; 0: never
};

// Every topic of the system. The first rule that matches counts.
inline constexpr std::array kTopicRules = {
    TopicRule{"device/*/state", TopicClass::kLatest, MessageType::kDeviceState, 10'000'000},
    TopicRule{"device/*/command", TopicClass::kLatest, MessageType::kDeviceCommand, 10'000'000},
    TopicRule{"haptic/*/proxy", TopicClass::kLatest, MessageType::kHapticProxy, 10'000'000},
    TopicRule{"contacts/*", TopicClass::kLatest, MessageType::kContactSet, 10'000'000},
    TopicRule{"physics/state", TopicClass::kLatest, MessageType::kPhysicsState, 20'000'000},
    TopicRule{"physics/sheet/*", TopicClass::kLatest, MessageType::kSheetState, 0},
    TopicRule{"physics/*/reaction", TopicClass::kLatest, MessageType::kReaction, 10'000'000},
    TopicRule{"logic/status", TopicClass::kState, MessageType::kLogicStatus, 0},
    TopicRule{"figures/*", TopicClass::kState, MessageType::kFigures, 0},
    TopicRule{"bulk/*", TopicClass::kState, MessageType::kBulkOffer, 0},
    TopicRule{"event", TopicClass::kEvent, MessageType::kEvent, 0},
    TopicRule{"param/set", TopicClass::kService, MessageType::kParameterChange, 0},
};

// '*' in the pattern matches any text, also none. Patterns come from other processes: only the last star is ever tried
// again, so the time is at most the product of the lengths.
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

// Topic id on the wire: a hash of the name, so that nobody has to hand out numbers. The registry refuses collisions.
inline std::uint32_t TopicId(std::string_view topic) {
  return static_cast<std::uint32_t>(core::Hash64(topic));
}

// Names of the topics, in one place.
inline std::string DeviceStateTopic(std::string_view role) {
  return "device/" + std::string(role) + "/state";
}
inline std::string DeviceCommandTopic(std::string_view role) {
  return "device/" + std::string(role) + "/command";
}
inline std::string HapticProxyTopic(std::string_view role) {
  return "haptic/" + std::string(role) + "/proxy";
}
inline std::string ReactionTopic(std::string_view role) {
  return "physics/" + std::string(role) + "/reaction";
}
inline std::string SheetTopic(std::string_view object) {
  return "physics/sheet/" + std::string(object);
}
inline std::string ContactsTopic(std::string_view source, std::string_view pair) {
  return "contacts/" + std::string(source) + "/" + std::string(pair);
}
inline std::string FiguresTopic(std::string_view node) {
  return "figures/" + std::string(node);
}
inline std::string BulkTopic(std::string_view node) {
  return "bulk/" + std::string(node);
}
inline constexpr const char* kPhysicsStateTopic = "physics/state";
inline constexpr const char* kLogicStatusTopic = "logic/status";
inline constexpr const char* kEventTopic = "event";
inline constexpr const char* kParameterTopic = "param/set";

}  // namespace bus
