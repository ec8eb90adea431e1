#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "bus/accounts/ledger.hpp"

namespace bus::detail {

// The accounts of one node. An account is closed when its peer leaves or dies, and messages under way then count as
// dropped for that reason; it is reopened when the same instance of the peer returns. Addresses of accounts are stable
// until a closed one is folded: the oldest closed ones are summed up by topic and side (peer ""), so that memory stays
// bounded while readers come and go for days.
class AccountBook {
 public:
  // Finds the account, or creates it with this start; it is open afterwards.
  Account& Open(const std::string& topic, TopicClass topic_class, const std::string& peer, std::uint64_t instance,
                bool is_writer, std::uint64_t start);
  [[nodiscard]] Account* Find(std::uint32_t topic, std::uint64_t instance, bool is_writer);
  void CloseAll(std::uint64_t instance);
  // In closed ones, messages that were under way count as dropped.
  [[nodiscard]] std::vector<Account> All() const;
  // The sum over all peers of one topic and side, folded ones included.
  [[nodiscard]] Account Total(const std::string& topic, bool is_writer) const;

 private:
  struct Entry {
    Account account;
    bool is_closed = false;
    [[nodiscard]] Account Shown() const;
  };
  using Key = std::tuple<std::uint64_t, bool, std::uint32_t>;  // instance, is the writer, topic
  static constexpr std::size_t kMaxClosed =
      512;  // bounds memory to some 200 KB; a peer that returns later has lost its account

  void Fold(const Key& key);
  std::map<Key, Entry> entries_;
  std::deque<Key> closed_;  // oldest first
  std::map<std::pair<std::string, bool>, Account> folded_;
};

// Adds the counts of one account to another.
void AddCounts(const Account& from, Account* to);

}  // namespace bus::detail
