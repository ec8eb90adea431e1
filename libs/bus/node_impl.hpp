#pragma once

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>

#include "bus/bus_thread.hpp"
#include "bus/node_core.hpp"
#include "bus/wire/schema.hpp"

namespace bus {

// For node.cpp, node_topics.cpp, node_wait.cpp and bulk.cpp.
struct Node::Impl {
  detail::NodeCore core;
  detail::BusThread bus{&core};

  static constexpr std::size_t kBatch = 32;  // datagrams per recvmmsg: saves system calls for 38 KB of buffers

  // Buffers of recvmmsg.
  std::array<std::array<std::uint8_t, kMaxDatagramBytes + 1>, kBatch> buffers;
  std::array<iovec, kBatch> vectors;
  std::array<mmsghdr, kBatch> headers;
  Envelope envelope;

  // What an observer has received of the present life of a topic's writer. Not real-time.
  struct ObservedLife {
    std::uint64_t boot = 0;
    detail::SequenceTracker tracker;
  };
  std::map<std::uint32_t, ObservedLife> observed;  // by topic

  Impl() {
    for (std::size_t i = 0; i < kBatch; ++i) {
      vectors[i] = {buffers[i].data(), buffers[i].size()};
      headers[i] = {};
      headers[i].msg_hdr.msg_iov = &vectors[i];
      headers[i].msg_hdr.msg_iovlen = 1;
    }
  }

  // The rule of the topic; null, with the error kept for Start(), when its class or type is another.
  const TopicRule* CheckTopic(const std::string& topic, TopicClass topic_class, MessageType type) {
    const TopicRule* rule = FindTopicRule(topic);
    if (rule != nullptr && rule->topic_class == topic_class && rule->type == type) return rule;
    core.declaration_errors.push_back("topic '" + topic + "': " +
                                      (rule == nullptr ? "no rule in libs/bus/topics.hpp matches it"
                                                       : "it carries " + SchemaOf(rule->type).name + ", not " +
                                                             SchemaOf(type).name + ", or is of another class"));
    return nullptr;
  }

  detail::LatestReceiver* FindReceiver(std::uint32_t id) {
    const auto found =
        std::lower_bound(core.receivers.begin(), core.receivers.end(), id,
                         [](const auto& receiver, std::uint32_t wanted) { return receiver->id < wanted; });
    return found != core.receivers.end() && (*found)->id == id ? found->get() : nullptr;
  }

  int TakeFirst(const detail::UdpSocket& socket);
  int TakeDatagrams();
  int TakeDatagrams(const detail::UdpSocket& socket);
  void TakeDatagram(std::span<std::uint8_t> bytes, std::int64_t now_ns, bool is_of_group);
  void Observe(std::span<const std::uint8_t> payload, std::size_t num_bytes, std::int64_t now_ns);
  bool IsNewToObserver(ObservedLife* life) const;
  void TakeStates();
};

}  // namespace bus
