#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bus/topics.hpp"

namespace bus {

// Exact counts since the node started, in messages: one that was split into several datagrams counts once, and is
// received when all its parts are there.
struct TopicCounters {
  std::string topic;
  TopicClass topic_class = TopicClass::kLatest;
  bool is_written = false;  // by this node; otherwise read
  std::uint64_t sent = 0;   // messages times subscribers
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;    // lost on the way (sequence gaps), refused by the socket when sending, or counted in
                                // `overflows` and `oversize` below
  std::uint64_t reordered = 0;  // LATEST: received after a newer one, so never the newest value
  std::uint64_t restored = 0;   // LATEST: lost, but restored from the copy in a later datagram
  std::uint64_t repeated = 0;   // LATEST: duplicates; not in `received`
  std::uint64_t overflows = 0;  // refused to the step thread: its queue to the bus thread was full
  std::uint64_t oversize = 0;   // refused to the step thread: a STATE value of more than 64 KiB
};

// Input that was refused, by reason. Datagrams: the names of detail::Refusal. "fenced": from a fenced instance.
// "connection": its handshake failed, or the limit was reached. "message": a ZeroMQ message that is unreadable or not
// allowed. "bulk": connections and messages refused by the BULK socket.
struct RefusalCount {
  std::string reason;
  std::uint64_t count = 0;
};

// Whenever nothing is under way, for each LATEST topic: sent = received + restored + dropped.
struct Counters {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;
  std::uint64_t refused = 0;           // total: garbage, another session, not authentic, replayed, unknown topic, ...
  std::vector<RefusalCount> refusals;  // the same by reason; empty for peers (heartbeats carry the total only)
  std::vector<TopicCounters>
      topics;  // param/set: calls are written, answers are read; `dropped` counts local drops only
};

// One end's account of a topic (ledger.hpp), as a peer reports it in its heartbeats.
struct ReportedAccount {
  std::string topic;
  std::string peer;  // the other end; empty: the sum over peers that left long ago
  bool is_writer = false;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;
  // Between the present lives of both ends, on which the two must agree (reported_accounts.hpp).
  std::uint64_t life_sent = 0;
  std::uint32_t peer_life = 0;  // low half of the other's instance; 0: none
  std::int64_t heard_ns = 0;    // when the report arrived, CLOCK_MONOTONIC of this node
};

// Another node as this one sees it.
struct PeerStatus {
  std::string name;
  std::uint64_t instance = 0;  // differs after a restart
  std::uint32_t process_id = 0;
  bool is_alive = false;    // heard within the last 0.35 s
  bool is_stalled = false;  // alive, but its step thread has not come back to Wait() for 0.4 s
  bool is_observer = false;
  std::int64_t age_ns = 0;     // since the last heartbeat
  std::uint32_t restarts = 0;  // seen by this node
  // Its clock minus this node's, within +- the bound; the same machine: exactly 0 and 0. Unknown: INT64_MAX.
  std::int64_t clock_offset_ns = 0;
  std::int64_t clock_bound_ns = 0;
  double clock_drift_ppm = 0.0;
  // The largest bound while it was alive, from 1 s after the first clock comparison on; none yet: INT64_MAX.
  std::int64_t largest_clock_bound_ns = 0;
  std::string udp_endpoint;               // "127.0.0.1:41234"
  std::string router_endpoint;            // "tcp://127.0.0.1:41235"
  Counters counters;                      // from its heartbeats
  std::uint64_t events_dropped = 0;       // events that it missed because it was away or too slow
  std::vector<ReportedAccount> accounts;  // from its heartbeats
};

}  // namespace bus
