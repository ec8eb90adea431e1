#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bus/membership/roster.hpp"

namespace bus {

// Compares the two ends of each account, as an observer gets them in the peers' heartbeats. The two reports arrive at
// different times and messages are under way, so one end's count is compared with the other end's count
// kCompareAfter_ns later: by then each message has arrived or is known to be lost, and has been reported.
//
//   sent by the writer, earlier   <=  known to the reader, now     violated: messages vanish uncounted
//   known to the reader, earlier  <=  sent by the writer, now      violated: messages are counted that were never sent
//
// Only the present lives of both ends are compared. SERVICE is left out: a request is repeated until it is answered, so
// its two ends do not count the same.
class ReportedAccounts {
 public:
  // 20 heartbeats: enough for all accounts to travel, 8 in each (kAccountsPerHeartbeat), at up to 160 accounts a node.
  static constexpr std::int64_t kCompareAfter_ns = 1'000'000'000;

  explicit ReportedAccounts(std::string pattern = "*") : pattern_(std::move(pattern)) {}  // of topics
  // Takes the present reports of all peers (Node::Peers); call it repeatedly.
  void Update(const std::vector<PeerStatus>& peers);
  // One line for each pair that disagreed in its latest comparison. Empty: all agree.
  [[nodiscard]] std::vector<std::string> Disagreements() const;
  [[nodiscard]] std::size_t num_compared() const;  // pairs

 private:
  struct End {
    std::uint64_t instance = 0;
    std::uint64_t sent = 0;
    std::int64_t heard_ns = 0;
  };
  struct Pair {
    End writer, reader;  // as reported earlier
    bool is_compared = false;
    std::string fault;
  };
  using Key = std::tuple<std::string, std::string, std::string>;  // topic, writer, reader
  static void Compare(const Key& key, const End& writer, const End& reader, Pair* pair);

  std::string pattern_;
  std::map<Key, Pair> pairs_;
};

}  // namespace bus
