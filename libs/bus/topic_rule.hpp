#pragma once

#include <cstdint>
#include <string_view>

namespace bus {

enum class MessageType : std::uint8_t;  // bus/topic_table.hpp

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

// A row of the topic table.
struct TopicRule {
  std::string_view pattern;  // '*' stands for any text, slashes included (role and pair names may hold them)
  TopicClass topic_class;
  MessageType type;
  std::int64_t max_age_ns;  // older than this is stale; 0: never
};

}  // namespace bus
