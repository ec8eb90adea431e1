#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "bus/ledger.hpp"

namespace bus::detail {

// The accounts of one node. One is closed when its peer leaves or dies, and what is on its way then is dropped for that
// reason; it is opened again when the same instance of the peer comes back. Addresses of accounts are stable until a
// closed one is folded: the oldest closed ones are summed up by topic and side (peer ""), so that a node whose readers
// come and go for days does not grow.
class AccountBook {
 public:
  // Found, or made with this start. Open from then on.
  Account& Open(const std::string& topic, TopicClass topic_class, const std::string& peer, std::uint64_t instance,
                bool is_writer, std::uint64_t start);
  [[nodiscard]] Account* Find(std::uint32_t topic, std::uint64_t instance, bool is_writer);
  void CloseAll(std::uint64_t instance);
  // Closed ones show what was on its way as dropped.
  [[nodiscard]] std::vector<Account> All() const;
  // Of one topic and side, over all peers, folded ones included.
  [[nodiscard]] Account Total(const std::string& topic, bool is_writer) const;

 private:
  struct Entry {
    Account account;
    bool is_closed = false;
    [[nodiscard]] Account Shown() const;
  };
  using Key = std::tuple<std::uint64_t, bool, std::uint32_t>;  // instance, is the writer, topic
  static constexpr std::size_t kMaxClosed = 512;

  void Fold(const Key& key);
  std::map<Key, Entry> entries_;
  std::deque<Key> closed_;  // oldest first
  std::map<std::pair<std::string, bool>, Account> folded_;
};

// Adds the counts of one account to another.
void AddCounts(const Account& from, Account* to);

}  // namespace bus::detail
