#include "bus/accounts/reported_accounts.hpp"

#include <algorithm>

namespace bus {
namespace {

bool Takes(const PeerStatus& peer) {
  return peer.is_alive && !peer.is_observer;
}

// The account of `peer` with `other` in the present lives of both; null: it reports none.
const ReportedAccount* FindWith(const PeerStatus& peer, const std::string& topic, const PeerStatus& other,
                                bool is_writer) {
  for (const ReportedAccount& reported : peer.accounts) {
    if (reported.is_writer != is_writer || reported.peer != other.name || reported.topic != topic) continue;
    return reported.peer_life == static_cast<std::uint32_t>(other.instance) ? &reported : nullptr;
  }
  return nullptr;
}

}  // namespace

void ReportedAccounts::Update(const std::vector<PeerStatus>& peers) {
  std::map<Key, Pair> seen;
  for (const PeerStatus& writer : peers) {
    if (!Takes(writer)) continue;
    for (const ReportedAccount& written : writer.accounts) {
      if (!written.is_writer || written.peer_life == 0 || !MatchesPattern(pattern_, written.topic)) continue;
      const auto reader = std::find_if(peers.begin(), peers.end(),
                                       [&written](const PeerStatus& peer) { return peer.name == written.peer; });
      if (reader == peers.end() || !Takes(*reader)) continue;
      if (FindWith(writer, written.topic, *reader, true) == nullptr) continue;
      const ReportedAccount* read = FindWith(*reader, written.topic, writer, false);
      if (read == nullptr) continue;
      const Key key{written.topic, writer.name, reader->name};
      Pair& pair = seen[key];
      if (const auto known = pairs_.find(key); known != pairs_.end()) pair = known->second;
      Compare(key, {writer.instance, written.life_sent, written.heard_ns},
              {reader->instance, read->life_sent, read->heard_ns}, &pair);
    }
  }
  pairs_ = std::move(seen);  // a pair whose peer left or returned starts afresh
}

void ReportedAccounts::Compare(const Key& key, const End& writer, const End& reader, Pair* pair) {
  if (pair->writer.instance != writer.instance || pair->reader.instance != reader.instance) {
    *pair = {writer, reader, false, {}};
    return;
  }
  const std::int64_t then_ns = std::max(pair->writer.heard_ns, pair->reader.heard_ns);
  if (std::min(writer.heard_ns, reader.heard_ns) < then_ns + kCompareAfter_ns) return;
  const auto& [topic, from, to] = key;
  const std::string what = topic + " from " + from + " to " + to + ": ";
  pair->fault.clear();
  if (reader.sent < pair->writer.sent) {
    pair->fault = what + std::to_string(pair->writer.sent) + " had been sent, and later its reader knows of " +
                  std::to_string(reader.sent);
  } else if (writer.sent < pair->reader.sent) {
    pair->fault = what + "its reader had counted " + std::to_string(pair->reader.sent) + ", and later only " +
                  std::to_string(writer.sent) + " were sent";
  }
  pair->writer = writer;
  pair->reader = reader;
  pair->is_compared = true;
}

std::vector<std::string> ReportedAccounts::Disagreements() const {
  std::vector<std::string> faults;
  for (const auto& [key, pair] : pairs_) {
    if (!pair.fault.empty()) faults.push_back(pair.fault);
  }
  return faults;
}

std::size_t ReportedAccounts::num_compared() const {
  return static_cast<std::size_t>(
      std::count_if(pairs_.begin(), pairs_.end(), [](const auto& item) { return item.second.is_compared; }));
}

}  // namespace bus
