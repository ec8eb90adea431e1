// The bus thread's part of LATEST: the readers of each topic, and the detour by ZeroMQ for NodeOptions::tcp_topics. A
// detoured datagram is exactly the one that would have gone by UDP, sealed and numbered:
//
//   step thread --ring--> bus thread --ROUTER, DEALER--> the reader's bus thread --loopback--> its data socket
//
// so the reader's step thread receives, checks and counts it like all others.

#include <algorithm>
#include <cstring>
#include <span>

#include "bus/bus_thread.hpp"

namespace bus::detail {
namespace {

constexpr std::size_t kClassPlace = 5;  // bus/wire/envelope.hpp

}  // namespace

void BusThread::UpdateSubscribers() {
  are_subscribers_outdated_ = false;
  for (const auto& sender : core_->senders) {
    Subscribers readers;
    for (const auto& [name, peer] : peers_) {
      if (!core_->peers[name].is_alive || is_fenced_) continue;
      bool reads = false;
      Subscriber reader{peer.data_address, peer.record.instance(), 0, false, false};
      reader.is_in_group =
          !core_->options.multicast.empty() && peer.record.multicast_group() == core_->options.multicast;
      for (const oos::TopicDeclaration& topic : peer.record.topics()) {
        if (topic.is_written() || topic.name() != sender->topic) continue;
        reads = true;
        reader.wants_history = reader.wants_history || topic.keeps_history();
      }
      for (const std::string& pattern : peer.record.observed_patterns()) {
        if (!MatchesPattern(pattern, sender->topic)) continue;
        reads = true;
        reader.wants_history = true;
      }
      if (reads && !readers.push_back(reader)) {
        Announce("subscriber_limit",
                 sender->topic + ": no room for " + name + " beside " + std::to_string(kMaxSubscribers) + " others");
      }
    }
    sender->SetReaders(readers);
  }
}

void BusThread::DrainDetours() {
  for (const auto& sender : core_->senders) {
    if (sender->detour == nullptr) continue;
    while (const DetouredDatagram* datagram = sender->detour->Front()) {
      for (const auto& [name, peer] : peers_) {
        const std::uint64_t instance = peer.record.instance();
        const auto& readers = datagram->readers;
        if (std::find(readers.begin(), readers.end(), instance) == readers.end()) continue;
        // One that does not get through is a sequence gap, which its reader counts.
        SendBytesToRouted(name + "#" + std::to_string(instance), {datagram->bytes.data(), datagram->size});
      }
      sender->detour->EndPop();
    }
  }
}

// False: not a detoured datagram.
bool BusThread::TakeDetoured(std::span<const std::uint8_t> bytes) {
  std::uint32_t magic = 0;
  if (bytes.size() < kEnvelopeFixedBytes || bytes.size() > kMaxDatagramBytes) return false;
  std::memcpy(&magic, bytes.data(), sizeof magic);
  if (magic != kEnvelopeMagic || bytes[kClassPlace] != static_cast<std::uint8_t>(TopicClass::kLatest)) return false;
  core_->heartbeat_socket.Send(own_data_address_, bytes.data(), bytes.size());
  return true;
}

}  // namespace bus::detail
