// The declarations of topics that a node writes and reads, before Start().

#include <algorithm>

#include "bus/node.hpp"
#include "bus/node_impl.hpp"

namespace bus {
namespace {

bool MatchesAny(const std::vector<std::string>& patterns, const std::string& topic) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&topic](const std::string& pattern) { return MatchesPattern(pattern, topic); });
}

}  // namespace

template <class M>
LatestWriter<M> Node::WriteLatest(const std::string& topic) {
  detail::NodeCore& core = impl_->core;
  impl_->CheckTopic(topic, TopicClass::kLatest, kMessageTypeOf<M>);
  for (const auto& sender : core.senders) {
    if (sender->topic == topic)
      core.declaration_errors.push_back("topic '" + topic + "' is declared twice for writing");
  }
  auto sender = std::make_unique<detail::TypedSender<M>>(topic);
  sender->envelope.session = core.identity.session;
  sender->envelope.node = core.identity.node;
  sender->envelope.boot = core.identity.boot;
  sender->socket = &core.data_socket;
  if (!core.options.multicast.empty()) detail::ParseEndpoint(core.options.multicast, &sender->group);
  if (MatchesAny(core.options.tcp_topics, topic)) {
    sender->detour = std::make_unique<detail::Detour>(detail::kDetourCapacity);
    sender->wake_fd = core.wake_fd;
  }
  sender->guard = core.guard.get();
  sender->tap = core.tap.tap();
  sender->tap_slot = core.tap.Declare(log::TapKind::kSent, topic, TopicClass::kLatest, kMessageTypeOf<M>);
  LatestWriter<M> writer;
  writer.sender_ = sender.get();
  core.senders.push_back(std::move(sender));
  return writer;
}

template <class M>
LatestReader<M>& Node::ReadLatest(const std::string& topic) {
  detail::NodeCore& core = impl_->core;
  const TopicRule* rule = impl_->CheckTopic(topic, TopicClass::kLatest, kMessageTypeOf<M>);
  for (const auto& receiver : core.receivers) {
    if (receiver->topic == topic && receiver->type == kMessageTypeOf<M>) {
      return static_cast<detail::TypedReceiver<M>*>(receiver.get())->reader;
    }
  }
  auto receiver = std::make_unique<detail::TypedReceiver<M>>(topic, rule != nullptr ? rule->max_age_ns : 0);
  LatestReader<M>& reader = receiver->reader;
  receiver->tap = core.tap.tap();
  receiver->tap_slot = core.tap.Declare(log::TapKind::kTaken, topic, TopicClass::kLatest, kMessageTypeOf<M>);
  const auto place = std::upper_bound(core.receivers.begin(), core.receivers.end(), receiver->id,
                                      [](std::uint32_t id, const auto& other) { return id < other->id; });
  core.receivers.insert(place, std::move(receiver));
  return reader;
}

template <class M>
StateWriter<M> Node::WriteState(const std::string& topic) {
  detail::NodeCore& core = impl_->core;
  impl_->CheckTopic(topic, TopicClass::kState, kMessageTypeOf<M>);
  auto sender = std::make_unique<detail::StateSender>();
  sender->topic = topic;
  sender->type = kMessageTypeOf<M>;
  sender->slot = static_cast<std::uint32_t>(core.state_senders.size());
  sender->core = &core;
  core.tap.DeclareStateWriter(topic, kMessageTypeOf<M>);
  StateWriter<M> writer;
  writer.sender_ = sender.get();
  core.state_senders.push_back(std::move(sender));
  return writer;
}

template <class M>
StateReader<M>& Node::ReadState(const std::string& topic) {
  detail::NodeCore& core = impl_->core;
  impl_->CheckTopic(topic, TopicClass::kState, kMessageTypeOf<M>);
  auto receiver = std::make_unique<detail::TypedStateReceiver<M>>(topic);
  StateReader<M>& reader = receiver->reader;
  core.tap.DeclareStateReader(topic, kMessageTypeOf<M>);
  core.state_receivers.push_back(std::move(receiver));
  return reader;
}

template <class M>
bool StateWriter<M>::Set(const M& value, const std::string& key) {
  if (sender_ == nullptr) return false;
  detail::StateItem* slot = sender_->core->states_out.BeginPush();
  if (slot == nullptr) {
    sender_->overflows.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  slot->slot = sender_->slot;
  slot->key = key;
  EncodeState(value, &slot->bytes);
  if (slot->bytes.size() > detail::kMaxStateBytes) {
    sender_->oversize.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  sender_->core->tap.WroteState(sender_->slot, key, slot->bytes);
  sender_->core->states_out.EndPush();
  sender_->core->Wake();
  return true;
}

void Node::ReadEvents() {
  impl_->core.reads_events = true;
}
void Node::OwnParameters(std::vector<std::string> names) {
  impl_->core.parameter_names = std::move(names);
}
void Node::Observe(const std::string& pattern) {
  impl_->core.observed_patterns.push_back(pattern);
}

#define LATEST_TOPICS(Message)                                                \
  template LatestWriter<core::Message> Node::WriteLatest(const std::string&); \
  template LatestReader<core::Message>& Node::ReadLatest(const std::string&);
BUS_LATEST_MESSAGES(LATEST_TOPICS)
#define STATE_TOPICS(Message)                                               \
  template StateWriter<core::Message> Node::WriteState(const std::string&); \
  template StateReader<core::Message>& Node::ReadState(const std::string&); \
  template class StateWriter<core::Message>;
BUS_STATE_MESSAGES(STATE_TOPICS)

}  // namespace bus
