#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>

#include "bus/topics.hpp"

namespace bus {

// Why a message was not delivered on its own.
enum class DropReason : std::uint8_t {
  kSuperseded,  // STATE: its value, or a newer one, came with a snapshot
  kOverrun,     // EVENT: the reader was away or too slow for longer than the writer keeps events
  kReaderGone,  // not acknowledged when the reader left or died (it may have arrived)
  kWriterGone,  // reported by the writer, but not here when it left or died
  kLost,        // LATEST: lost on the way, or came after a newer one
  kUnanswered,  // SERVICE: no answer before the deadline
};
constexpr std::size_t kNumDropReasons = 6;

constexpr std::string_view NameOf(DropReason reason) {
  constexpr std::array<std::string_view, kNumDropReasons> kNames = {"superseded",  "overrun", "reader_gone",
                                                                    "writer_gone", "lost",    "unanswered"};
  return kNames[static_cast<std::size_t>(reason)];
}

// A LATEST topic between one life of the writer and one of the reader. The writer knows only which sequences it sent to
// the reader, first .. last; the reader counts what became of each. Whenever nothing is under way and both ends refer
// to the same boot, the two independent counts satisfy
//
//   (last - first + 1 of the writer) + early = received + restored + lost (of the reader).
struct LatestLife {
  std::uint64_t instance = 0;  // of the writer
  std::uint64_t boot = 0;      // of its envelopes; 0: the writer has not reported any
  std::uint64_t first = 0;     // sent to the reader: first .. last
  std::uint64_t last = 0;
  std::uint64_t received = 0;
  std::uint64_t restored = 0;    // came as a copy with a later one
  std::uint64_t lost = 0;        // sequences known to be missing
  std::uint64_t early = 0;       // before `first`: datagrams for other readers of its multicast group
  std::uint64_t on_the_way = 0;  // reported by the writer, but neither here nor known to be lost

  // Messages that the writer reports to have sent.
  [[nodiscard]] std::uint64_t reported() const { return boot == 0 ? 0 : last - first + 1; }
  // Messages sent to the reader, by the reader's own count.
  [[nodiscard]] std::uint64_t counted() const { return received + restored + lost + on_the_way - early; }
};

// Messages from one writer to one reader on one topic, as one of the two counts them. Whenever nothing is under way,
// sent = received + dropped, exactly, and the accounts of both ends agree. LATEST: the reader's account sums over all
// lives of the writer, which the writer's cannot; the part on which both must agree is `life`.
struct Account {
  std::string topic;
  TopicClass topic_class = TopicClass::kEvent;
  std::string peer;  // the other end
  std::uint64_t peer_instance = 0;
  bool is_writer = false;      // this node is the writer, `peer` the reader
  std::uint64_t start = 0;     // messages of the topic before the first one for this reader
  std::uint64_t sent = 0;      // to this reader; the reader learns it from messages and heartbeats
  std::uint64_t received = 0;  // LATEST: includes restored copies; stays 0 at the writer, which gets no acknowledgement
  std::array<std::uint64_t, kNumDropReasons> dropped{};
  LatestLife life{};  // LATEST: the writer's last life

  [[nodiscard]] std::uint64_t dropped_for(DropReason reason) const { return dropped[static_cast<std::size_t>(reason)]; }
  [[nodiscard]] std::uint64_t dropped_in_all() const {
    return std::accumulate(dropped.begin(), dropped.end(), std::uint64_t{0});
  }
  [[nodiscard]] bool is_settled() const {
    return sent == received + dropped_in_all() || (is_writer && topic_class == TopicClass::kLatest);
  }
};

// For people: "event from physics_node: sent 12 = received 10 + overrun 2".
std::string Describe(const Account& account);

}  // namespace bus
