#include "bus/accounts/accounts.hpp"

#include <map>
#include <tuple>

#include "bus/node_core.hpp"

namespace bus::detail {
namespace {

Account MakeLatest(const std::string& topic, bool is_writer) {
  Account account;
  account.topic = topic;
  account.topic_class = TopicClass::kLatest;
  account.is_writer = is_writer;
  return account;
}

void AddWritten(const NodeCore& core, const LatestSender& sender, std::vector<Account>* all) {
  for (const SpanAccount& span : sender.spans) {
    const std::uint64_t instance = span.instance.load(std::memory_order_acquire);
    const std::uint64_t first = span.first.load(std::memory_order_acquire);
    const std::uint64_t last = span.last.load(std::memory_order_acquire);
    if (instance == 0 || first == 0 || span.instance.load(std::memory_order_acquire) != instance) continue;
    Account account = MakeLatest(sender.topic, true);
    for (const auto& [name, peer] : core.peers) {
      if (peer.instance == instance) account.peer = name;
    }
    account.peer_instance = instance;
    account.start = first - 1;
    account.sent = last - first + 1;
    account.life = {core.instance, sender.envelope.boot, first, last};
    all->push_back(std::move(account));
  }
}

void AddRead(const NodeCore& core, const LatestReceiver& receiver, std::vector<Account>* all) {
  const LatestCounts counts = receiver.Counts();
  Account account = MakeLatest(receiver.topic, false);
  if (const auto known = core.known_topics.find(receiver.id); known != core.known_topics.end()) {
    account.peer = known->second.writer;
  }
  if (const auto peer = core.peers.find(account.peer); peer != core.peers.end()) {
    account.peer_instance = peer->second.instance;
  }
  account.received = counts.received + counts.restored;
  account.dropped[static_cast<std::size_t>(DropReason::kLost)] = counts.dropped;
  account.sent = counts.meant;
  account.life = receiver.Life();
  if (account.sent > 0) all->push_back(std::move(account));
}

}  // namespace

std::vector<Account> AllAccounts(const NodeCore& core) {
  std::vector<Account> all = core.book.All();
  for (const auto& sender : core.senders) AddWritten(core, *sender, &all);
  for (const auto& receiver : core.receivers) AddRead(core, *receiver, &all);
  return all;
}

std::vector<Account> MergeByName(const std::vector<Account>& accounts) {
  std::map<std::tuple<std::string, std::string, bool>, Account> sums;
  for (const Account& account : accounts) {
    Account& sum = sums[{account.peer, account.topic, account.is_writer}];
    if (sum.topic.empty()) {
      sum = account;
    } else {
      AddCounts(account, &sum);
    }
  }
  std::vector<Account> merged;
  for (auto& [key, account] : sums) merged.push_back(std::move(account));
  return merged;
}

bool FindPresentLife(const NodeCore& core, const std::vector<Account>& accounts, const Account& merged,
                     std::uint64_t* sent, std::uint64_t* peer_instance) {
  // A request is repeated until it is answered, so the two ends count differently.
  const auto peer = core.peers.find(merged.peer);
  if (peer == core.peers.end() || merged.topic_class == TopicClass::kService) return false;
  *peer_instance = peer->second.instance;
  const bool is_read_latest = merged.topic_class == TopicClass::kLatest && !merged.is_writer;
  for (const Account& account : accounts) {
    if (account.topic != merged.topic || account.is_writer != merged.is_writer) continue;
    if (*peer_instance != (is_read_latest ? account.life.instance : account.peer_instance)) continue;
    *sent = is_read_latest ? account.life.counted() : account.sent;
    return true;
  }
  return false;
}

}  // namespace bus::detail
