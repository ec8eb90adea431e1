#include "bus/accounts/account_book.hpp"

namespace bus {

std::string Describe(const Account& account) {
  std::string text = account.topic + (account.is_writer ? " to " : " from ") +
                     (account.peer.empty() ? "earlier peers" : account.peer) + ": sent " + std::to_string(account.sent);
  if (account.is_writer && account.topic_class == TopicClass::kLatest) return text;
  text += (account.is_settled() ? " = received " : " != received ") + std::to_string(account.received);
  for (std::size_t i = 0; i < kNumDropReasons; ++i) {
    if (account.dropped[i] == 0) continue;
    text += " + " + std::string(NameOf(static_cast<DropReason>(i))) + " " + std::to_string(account.dropped[i]);
  }
  return text;
}

namespace detail {

void AddCounts(const Account& from, Account* to) {
  to->sent += from.sent;
  to->received += from.received;
  for (std::size_t i = 0; i < kNumDropReasons; ++i) to->dropped[i] += from.dropped[i];
}

Account AccountBook::Entry::Shown() const {
  Account shown = account;
  if (!is_closed) return shown;
  const std::uint64_t settled = shown.received + shown.dropped_in_all();
  const DropReason reason = shown.is_writer ? DropReason::kReaderGone : DropReason::kWriterGone;
  if (shown.sent > settled) shown.dropped[static_cast<std::size_t>(reason)] += shown.sent - settled;
  return shown;
}

Account& AccountBook::Open(const std::string& topic, TopicClass topic_class, const std::string& peer,
                           std::uint64_t instance, bool is_writer, std::uint64_t start) {
  const auto [item, is_new] = entries_.try_emplace({instance, is_writer, TopicId(topic)});
  Entry& entry = item->second;
  if (entry.is_closed) std::erase(closed_, item->first);
  entry.is_closed = false;
  if (is_new) {
    entry.account.topic = topic;
    entry.account.topic_class = topic_class;
    entry.account.peer = peer;
    entry.account.peer_instance = instance;
    entry.account.is_writer = is_writer;
    entry.account.start = start;
  }
  return entry.account;
}

Account* AccountBook::Find(std::uint32_t topic, std::uint64_t instance, bool is_writer) {
  const auto found = entries_.find({instance, is_writer, topic});
  return found == entries_.end() ? nullptr : &found->second.account;
}

void AccountBook::CloseAll(std::uint64_t instance) {
  for (auto item = entries_.lower_bound({instance, false, 0});
       item != entries_.end() && std::get<0>(item->first) == instance; ++item) {
    if (item->second.is_closed) continue;
    item->second.is_closed = true;
    closed_.push_back(item->first);
  }
  while (closed_.size() > kMaxClosed) {
    const Key oldest = closed_.front();
    closed_.pop_front();
    Fold(oldest);
  }
}

void AccountBook::Fold(const Key& key) {
  const auto found = entries_.find(key);
  const Account shown = found->second.Shown();
  Account& sum = folded_[{shown.topic, shown.is_writer}];
  sum.topic = shown.topic;
  sum.topic_class = shown.topic_class;
  sum.is_writer = shown.is_writer;
  AddCounts(shown, &sum);
  entries_.erase(found);
}

std::vector<Account> AccountBook::All() const {
  std::vector<Account> all;
  for (const auto& [key, entry] : entries_) all.push_back(entry.Shown());
  for (const auto& [key, account] : folded_) all.push_back(account);
  return all;
}

Account AccountBook::Total(const std::string& topic, bool is_writer) const {
  Account total;
  total.topic = topic;
  total.is_writer = is_writer;
  for (const auto& [key, entry] : entries_) {
    if (entry.account.is_writer == is_writer && entry.account.topic == topic) AddCounts(entry.Shown(), &total);
  }
  const auto folded = folded_.find({topic, is_writer});
  if (folded != folded_.end()) AddCounts(folded->second, &total);
  return total;
}

}  // namespace detail
}  // namespace bus
