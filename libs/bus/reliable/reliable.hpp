#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "bus/accounts/ledger.hpp"
#include "bus/reliable/event_log.hpp"

namespace bus::detail {

// Unacknowledged events (changes of STATE) in flight to one reader. A quarter of the writer's log (EventLog::kKept), so
// that several credits fit before a reader that stopped holds the writer up.
constexpr std::uint64_t kEventCredit = 1024;
constexpr std::uint64_t kStateCredit = 1024;

// The reading end of STATE and EVENT towards one peer.
struct PeerReading {
  bool is_subscribed = false;
  bool has_snapshot = false;
  bool is_held = false;                  // the step thread's queue was full: events were left for a retransmission
  std::int64_t subscribed_ns = 0;        // last SUBSCRIBE or eviction; the next one waits
  std::int64_t resend_requested_ns = 0;  // last request for a retransmission of events
  std::uint64_t state_version = 0;
  std::uint64_t announced_version = 0;  // newest version by its heartbeat
  std::int64_t state_behind_since_ns = 0;
  std::uint64_t seen_event = 0;  // EventPlace at the last check, and when it was reached
  std::int64_t seen_event_ns = 0;
  std::uint64_t acked_event = 0;
  std::uint64_t acked_state = 0;
};

// The writing end of STATE and EVENT towards one reader.
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
  bool is_state_behind = false;       // out of credit: no more changes until it has acknowledged all; then a snapshot
  bool is_evicted = false;            // gets nothing until it subscribes again
  std::int64_t starved_since_ns = 0;  // since when it holds the writer up; 0: it does not
  std::uint64_t heard_acks = 0;       // acknowledged events and changes at the last check, and when first seen
  std::int64_t heard_acks_ns = 0;
  Account* events = nullptr;
  std::map<std::uint32_t, Account*> states;  // by topic

  [[nodiscard]] bool HasEventCredit() const { return sent_event < acked_event + kEventCredit; }
};

}  // namespace bus::detail
