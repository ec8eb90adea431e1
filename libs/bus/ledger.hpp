#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>

#include "bus/topics.hpp"

namespace bus {

// Why a message did not arrive by itself.
enum class DropReason : std::uint8_t {
  kSuperseded,  // STATE: its value, or a newer one, came with a snapshot
  kOverrun,     // EVENT: the reader was away or too slow for longer than the writer keeps events
  kReaderGone,  // not acknowledged when the reader left or died (it may have arrived)
  kWriterGone,  // told by the writer, but not here when it left or died
  kLost,        // LATEST: lost on the way, or came after a newer one
  kUnanswered,  // SERVICE: no answer before the deadline
};
constexpr std::size_t kNumDropReasons = 6;

constexpr std::string_view NameOf(DropReason reason) {
  constexpr std::array<std::string_view, kNumDropReasons> kNames = {"superseded",  "overrun", "reader_gone",
                                                                    "writer_gone", "lost",    "unanswered"};
  return kNames[static_cast<std::size_t>(reason)];
}

// LATEST between one life of the writer and one of the reader. Its writer knows only what it meant for the reader; the
// reader counts what became of each message, so that, whenever nothing is on its way and both speak of the same boot,
//
//   (last - first + 1 of the writer) + early = received + restored + lost (of the reader)
//
// tests what both have counted.
struct LatestLife {
  std::uint64_t instance = 0;  // of the writer
  std::uint64_t boot = 0;      // of its envelopes; 0: the writer has not told of any
  std::uint64_t first = 0;     // meant for the reader: first .. last
  std::uint64_t last = 0;
  std::uint64_t received = 0;
  std::uint64_t restored = 0;    // came as a copy with a later one
  std::uint64_t lost = 0;        // that many sequences are known not to have come
  std::uint64_t early = 0;       // before the first that was meant for it: came for others of its multicast group
  std::uint64_t on_the_way = 0;  // told, but not settled yet

  [[nodiscard]] std::uint64_t told() const { return boot == 0 ? 0 : last - first + 1; }
  // What the reader knows to have been meant for it, by its own count.
  [[nodiscard]] std::uint64_t counted() const { return received + restored + lost + on_the_way - early; }
};

// What went from one writer to one reader on one topic, as one of the two counts it. Whenever nothing is on its way,
// sent = received + dropped, exactly, and the accounts of both ends agree. LATEST: the reader's account holds all lives
// of the writer together, which the writer's cannot; what both must agree about is in `life`.
struct Account {
  std::string topic;
  TopicClass topic_class = TopicClass::kEvent;
  std::string peer;  // the other end
  std::uint64_t peer_instance = 0;
  bool is_writer = false;      // this node is the writer of the two
  std::uint64_t start = 0;     // messages of the topic before the first that was meant for the reader
  std::uint64_t sent = 0;      // meant for the reader; its end knows it from messages and heartbeats
  std::uint64_t received = 0;  // LATEST: also what came only as a copy with a later message; the writer never knows
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

// "event from physics_node: sent 12 = received 10 + overrun 2", for people.
std::string Describe(const Account& account);

}  // namespace bus
