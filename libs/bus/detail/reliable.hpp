#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "bus/detail/event_log.hpp"
#include "bus/ledger.hpp"

namespace bus::detail {

constexpr std::uint64_t kEventCredit = 1024;  // events on their way to one reader that it has not acknowledged
constexpr std::uint64_t kStateCredit = 1024;  // the same for changes of STATE

// What a node reads from one peer by the reliable classes.
struct PeerReading {
  bool is_subscribed = false;
  bool has_snapshot = false;
  bool is_held = false;  // the step thread's queue was full: what came was left for later
  std::int64_t asked_ns = 0;
  std::int64_t asked_again_ns = 0;  // for events that are missing
  std::uint64_t state_version = 0;
  std::uint64_t told_version = 0;  // by its heartbeat
  std::int64_t state_behind_since_ns = 0;
  std::uint64_t seen_event = 0;  // place at the last look, and when it was reached
  std::int64_t seen_event_ns = 0;
  std::uint64_t acked_event = 0;
  std::uint64_t acked_state = 0;
};

// Somebody who reads from us.
struct Subscription {
  std::string name;
  std::uint64_t instance = 0;
  bool wants_state = false;
  bool wants_events = false;
  std::int64_t since_ns = 0;
  std::uint64_t sent_event = 0;
  std::uint64_t acked_event = 0;
  std::uint64_t sent_state = 0;  // version
  std::uint64_t acked_state = 0;
  bool is_state_behind = false;       // gets no changes until it has taken what it was sent; then a snapshot
  bool is_evicted = false;            // gets nothing until it subscribes again
  std::int64_t starved_since_ns = 0;  // something waits for its acknowledgement; 0: nothing does
  std::uint64_t heard_acks = 0;       // acknowledged events and changes at the last look, and when that was first seen
  std::int64_t heard_acks_ns = 0;
  Account* events = nullptr;
  std::map<std::uint32_t, Account*> states;  // by topic

  [[nodiscard]] bool HasEventCredit() const { return sent_event < acked_event + kEventCredit; }
};

}  // namespace bus::detail
