#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bus/roster.hpp"

namespace bus {

// Joins the two ends of each account as peers tell them. Heartbeats bring the ends at different times and messages are
// on their way, so what one end has on its books is compared with what the other tells kBetweenLooks_ns later: by then
// a message has arrived or is known to be lost, and what was sent has been told.
//
//   sent by the writer, then   <=  known to the reader, now        otherwise messages vanish uncounted
//   known to the reader, then  <=  sent by the writer, now         otherwise messages are counted that never were
//
// Only of lives that both ends are still in. SERVICE has no such pair: a request is sent again until it is answered.
class ToldAccounts {
 public:
  static constexpr std::int64_t kBetweenLooks_ns = 1'000'000'000;

  explicit ToldAccounts(std::string pattern = "*") : pattern_(std::move(pattern)) {}  // of topics
  // What peers tell now; call it again and again.
  void Look(const std::vector<PeerStatus>& peers);
  // Of each pair as it was last compared, for people. Empty: all agree.
  [[nodiscard]] std::vector<std::string> Disagreements() const;
  [[nodiscard]] std::size_t num_compared() const;  // pairs

 private:
  struct End {
    std::uint64_t instance = 0;
    std::uint64_t sent = 0;
    std::int64_t told_ns = 0;
  };
  struct Pair {
    End writer, reader;  // then
    bool is_compared = false;
    std::string fault;
  };
  using Key = std::tuple<std::string, std::string, std::string>;  // topic, writer, reader
  static void Compare(const Key& key, const End& writer, const End& reader, Pair* pair);

  std::string pattern_;
  std::map<Key, Pair> pairs_;
};

}  // namespace bus
