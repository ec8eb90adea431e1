// The writing end of STATE and EVENT: the readers of this node. All on the bus thread, with the node's mutex held.

#include <algorithm>

#include "bus/accounts/accounts.hpp"
#include "bus/bus_thread.hpp"
#include "bus/reliable/routed.hpp"
#include "core/clock.hpp"

namespace bus::detail {
namespace {

// A reader on a busy machine may be scheduled out for tens of ms; a longer one would hold up the others.
constexpr std::int64_t kSlowAfter_ns = 100 * core::kMillisecond_ns;
// Far above a round trip and the interval of acknowledgements, so that it is sent only when one was lost.
constexpr std::int64_t kRequestAckAfter_ns = 500 * core::kMillisecond_ns;
// A subscriber that stays out of the roster that long (20 HELLO periods) is forgotten.
constexpr std::int64_t kUnknownTooLong_ns = 10'000 * core::kMillisecond_ns;
// In turn; 20 heartbeats a second carry 160 accounts (kMaxHeartbeatBytes limits a heartbeat).
constexpr std::size_t kAccountsPerHeartbeat = 8;

}  // namespace

void BusThread::ReceiveFromRouter() {
  zmq::message_t routing, message;
  while (ReceiveRouted(&router_, &routing, &message)) {
    oos::Control control;
    if (!DecodeControl({message.data<std::uint8_t>(), message.size()}, core_->identity.session, &control)) {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    const std::string from = routing.to_string();
    if (!IsAdmitted(from, message)) continue;
    if (control.has_subscribe()) {
      TakeSubscribe(from, control.subscribe());
    } else if (control.has_event_ack()) {
      TakeEventAck(from, control.event_ack());
    } else if (control.has_parameter_request()) {
      TakeRequest(from, control.parameter_request());
    } else {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
    }
  }
}

// The reader's end of an account replaces this node's counts: the reader knows what arrived.
void BusThread::TakeReading(const oos::Reading& reading, std::uint64_t instance) {
  Account* account = core_->book.Find(reading.topic(), instance, true);
  if (account == nullptr) return;
  account->start = reading.start();
  account->received = reading.received();
  const DropReason reason = account->topic_class == TopicClass::kEvent ? DropReason::kOverrun : DropReason::kSuperseded;
  account->dropped[static_cast<std::size_t>(reason)] = reading.dropped();
}

void BusThread::TakeSubscribe(const std::string& routing, const oos::Subscribe& subscribe) {
  // A restarted reader has a new routing id; its old subscription is void.
  std::vector<std::uint64_t> earlier;
  for (const auto& [other, subscription] : subscriptions_) {
    if (subscription.name == subscribe.name() && subscription.instance != subscribe.instance()) {
      earlier.push_back(subscription.instance);
    }
  }
  for (const std::uint64_t instance : earlier) ForgetReader(subscribe.name(), instance);

  const auto [item, is_new] = subscriptions_.try_emplace(routing);
  Subscription& subscription = item->second;
  if (is_new) subscription.since_ns = core::MonotonicNow_ns();
  subscription.name = subscribe.name();
  subscription.instance = subscribe.instance();
  subscription.wants_state = subscribe.wants_state();
  subscription.wants_events = subscribe.wants_events();
  subscription.is_evicted = false;
  subscription.starved_since_ns = 0;
  const auto open = [&](const std::string& topic, TopicClass topic_class, std::uint64_t start, std::uint64_t count) {
    Account* account = &core_->book.Open(topic, topic_class, subscription.name, subscription.instance, true, start);
    for (const oos::Reading& reading : subscribe.readings()) {
      if (reading.topic() == TopicId(topic)) TakeReading(reading, subscription.instance);
    }
    account->start = std::min(account->start, count);
    account->sent = count - account->start;
    return account;
  };
  if (subscription.wants_state) {
    for (const auto& sender : core_->state_senders) {
      const std::uint32_t id = TopicId(sender->topic);
      subscription.states[id] = open(sender->topic, TopicClass::kState, own_counts_[id], own_counts_[id]);
    }
  }
  if (subscription.wants_events) {
    // Starts with the first event after the reader became known here, which is before node_found is reported: what is
    // emitted in answer to node_found reaches it.
    const auto peer = peers_.find(subscription.name);
    const bool is_known = peer != peers_.end() && peer->second.record.instance() == subscription.instance;
    const std::uint64_t start = is_known ? peer->second.events_before : event_log_.newest();
    const Account* events = open(kEventTopic, TopicClass::kEvent, start, event_log_.newest());
    subscription.events = core_->book.Find(TopicId(kEventTopic), subscription.instance, true);
    RewindEvents(subscription, events->start + events->received + events->dropped_in_all());
  }
  // If it does not get through, the reader subscribes again.
  if (!AckSubscription(routing, subscription)) return;
  if (subscription.wants_state) SendSnapshot(routing, subscription);
  PumpEvents(routing, subscription);
}

// Goes on after event `place`, or with the oldest that is kept.
void BusThread::RewindEvents(Subscription& subscription, std::uint64_t place) {
  place = std::clamp(place, event_log_.oldest() - 1, event_log_.newest());
  subscription.sent_event = place;
  subscription.acked_event = place;
}

bool BusThread::AckSubscription(const std::string& routing, const Subscription& subscription) {
  oos::Control control;
  oos::SubscribeAck* ack = control.mutable_subscribe_ack();
  ack->set_instance(core_->instance);
  ack->set_next_event(subscription.acked_event + 1);
  const auto add = [ack](const Account& account) {
    oos::Reading* start = ack->add_starts();
    start->set_topic(TopicId(account.topic));
    start->set_start(account.start);
  };
  if (subscription.events != nullptr) add(*subscription.events);
  for (const auto& [topic, account] : subscription.states) add(*account);
  return SendToRouted(routing, control);
}

void BusThread::SendSnapshot(const std::string& routing, Subscription& subscription) {
  oos::Control control;
  oos::StateSnapshot* snapshot = control.mutable_state_snapshot();
  snapshot->set_version(own_state_version_);
  for (const auto& [key, entry] : retained_) *snapshot->add_entries() = entry;
  for (const auto& [topic, account] : subscription.states) {
    oos::TopicCount* count = snapshot->add_counts();
    count->set_topic(topic);
    count->set_count(own_counts_[topic]);
  }
  subscription.is_state_behind = !SendToRouted(routing, control);
  if (subscription.is_state_behind) return;
  subscription.sent_state = own_state_version_;
  subscription.starved_since_ns = 0;
}

void BusThread::TakeEventAck(const std::string& routing, const oos::EventAck& ack) {
  for (const oos::Reading& reading : ack.readings()) TakeReading(reading, ack.instance());
  const auto found = subscriptions_.find(routing);
  if (found == subscriptions_.end() || found->second.is_evicted) {
    oos::Control control;
    control.mutable_eviction()->set_why("not subscribed");
    SendToRouted(routing, control);
    return;
  }
  Subscription& subscription = found->second;
  if (Peer* reader = FindReader(subscription); reader != nullptr && subscription.events != nullptr) {
    StatusOf(*reader).events_dropped = subscription.events->dropped_in_all();
  }
  subscription.acked_event =
      std::clamp(ack.sequence(), subscription.acked_event, std::max(subscription.sent_event, subscription.acked_event));
  subscription.acked_state = std::clamp(ack.state_version(), subscription.acked_state,
                                        std::max(subscription.sent_state, subscription.acked_state));
  if (ack.resend() && subscription.wants_events) {
    RewindEvents(subscription, ack.sequence());
    if (subscription.sent_event > ack.sequence()) AckSubscription(routing, subscription);
  }
  PumpEvents(routing, subscription);
}

void BusThread::Evict(const std::string& routing, Subscription& subscription, const std::string& why) {
  subscription.is_evicted = true;
  subscription.starved_since_ns = 0;
  oos::Control control;
  control.mutable_eviction()->set_why(why);
  SendToRouted(routing, control);  // if this is lost, its heartbeats show it the gap
  const core::Event event{core::MonotonicNow_ns(), core_->options.name, "peer_evicted", subscription.name};
  Announce(event.name, event.detail);
  AppendEvent(event);
}

void BusThread::MaintainSubscriptions() {
  const std::int64_t now = core::MonotonicNow_ns();
  std::vector<std::pair<std::string, std::uint64_t>> strangers;
  for (auto& [routing, subscription] : subscriptions_) {
    if (FindReader(subscription) == nullptr) {
      if (now - subscription.since_ns > kUnknownTooLong_ns) {
        strangers.emplace_back(subscription.name, subscription.instance);
      }
    } else {
      subscription.since_ns = now;
    }
    if (subscription.is_evicted) continue;
    PumpEvents(routing, subscription);
    RequestAcknowledgement(routing, &subscription, now);
    if (!subscription.is_state_behind) continue;
    if (subscription.acked_state >= subscription.sent_state) {
      SendSnapshot(routing, subscription);
    } else if (now - subscription.starved_since_ns > kSlowAfter_ns && FindReader(subscription) != nullptr) {
      Evict(routing, subscription, "no acknowledgement of STATE");
    }
  }
  for (const auto& [name, instance] : strangers) ForgetReader(name, instance);
}

// When an acknowledgement was lost with its connection, only the writer can notice: the reader has everything.
void BusThread::RequestAcknowledgement(const std::string& routing, Subscription* subscription, std::int64_t now_ns) {
  const std::uint64_t acks = subscription->acked_event + subscription->acked_state;
  if (acks != subscription->heard_acks || acks >= subscription->sent_event + subscription->sent_state) {
    subscription->heard_acks = acks;
    subscription->heard_acks_ns = now_ns;
  }
  if (now_ns - subscription->heard_acks_ns < kRequestAckAfter_ns || FindReader(*subscription) == nullptr) return;
  subscription->heard_acks_ns = now_ns;
  AckSubscription(routing, *subscription);
}

// The reader has left, died, or started again.
void BusThread::ForgetReader(const std::string& name, std::uint64_t instance) {
  std::erase_if(subscriptions_,
                [&](const auto& item) { return item.second.name == name && item.second.instance == instance; });
  core_->book.CloseAll(instance);
  const auto peer = peers_.find(name);
  if (peer != peers_.end() && peer->second.record.instance() == instance) {
    peer->second.events_before = event_log_.newest();
  }
}

bool BusThread::SendToRouted(const std::string& routing, const oos::Control& control) {
  return SendBytesToRouted(routing, EncodeControl(core_->identity, ClassOf(control), control));
}

bool BusThread::SendBytesToRouted(const std::string& routing, std::span<const std::uint8_t> bytes) {
  try {
    if (!router_.send(zmq::buffer(routing), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) return false;
    return router_.send(zmq::buffer(bytes.data(), bytes.size()), zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t&) {  // EHOSTUNREACH: it is gone
    return false;
  }
}

void BusThread::DrainStepThread() {
  while (const StateItem* item = core_->states_out.Front()) {
    SendState(*item);
    core_->states_out.EndPop();
  }
  DrainEvents();
  SendReplies();
  while (const ParameterCall* call = core_->calls_out.Front()) {
    OpenParameterCall(*call);
    core_->calls_out.EndPop();
  }
  for (const ParameterCall& call : core_->waiting_calls) OpenParameterCall(call);
  core_->waiting_calls.clear();
}

// Null when the reader is not alive.
BusThread::Peer* BusThread::FindReader(const Subscription& subscription) {
  const auto peer = peers_.find(subscription.name);
  const bool is_there = peer != peers_.end() && peer->second.record.instance() == subscription.instance;
  return is_there && StatusOf(peer->second).is_alive ? &peer->second : nullptr;
}

// At most one ring full: a step thread that never stops emitting must not keep acknowledgements and heartbeats waiting.
void BusThread::DrainEvents() {
  for (std::size_t i = 0; i < core_->events_out.capacity(); ++i) {
    const core::Event* event = core_->events_out.Front();
    if (event == nullptr) return;
    if (!is_stopping_.load() && IsHeldUpByReaders()) return;
    AppendEvent(*event);
    core_->events_out.EndPop();
  }
  core_->Wake();
}

// Back-pressure: the log keeps what may need retransmission. When it is full of events that a reader has not
// acknowledged, new ones stay in the step thread's ring, and once that is full Emit() returns false. A reader on a busy
// machine catches up within kSlowAfter_ns; a slower one is evicted, by name, and delays nobody until it subscribes
// again.
bool BusThread::IsHeldUpByReaders() {
  const std::int64_t now = core::MonotonicNow_ns();
  bool is_held_up = false;
  for (auto& [routing, subscription] : subscriptions_) {
    if (!subscription.wants_events || subscription.is_evicted) continue;
    if (event_log_.newest() - subscription.acked_event < EventLog::kKept) {
      if (!subscription.is_state_behind) subscription.starved_since_ns = 0;
      continue;
    }
    if (FindReader(subscription) == nullptr) continue;  // dead: not waited for
    if (subscription.starved_since_ns == 0) subscription.starved_since_ns = now;
    if (now - subscription.starved_since_ns < kSlowAfter_ns) {
      is_held_up = true;
    } else {
      Evict(routing, subscription, "no acknowledgement of EVENT");
    }
  }
  return is_held_up;
}

void BusThread::SendState(const StateItem& item) {
  StateSender& sender = *core_->state_senders[item.slot];
  const std::uint32_t id = TopicId(sender.topic);
  oos::StateEntry& entry = retained_[{sender.topic, item.key}];
  entry.set_topic(sender.topic);
  entry.set_key(item.key);
  entry.set_value(item.bytes);
  entry.set_version(++own_state_version_);
  entry.set_count(++own_counts_[id]);
  oos::Control control;
  *control.mutable_state_delta() = entry;
  const auto bytes = EncodeControl(core_->identity, TopicClass::kState, control);
  for (auto& [routing, subscription] : subscriptions_) {
    const auto account = subscription.states.find(id);
    if (account == subscription.states.end()) continue;
    account->second->sent = entry.count() - account->second->start;
    sender.sent.fetch_add(1, std::memory_order_relaxed);
    if (subscription.is_evicted || subscription.is_state_behind) continue;
    const bool has_credit = subscription.sent_state < subscription.acked_state + kStateCredit;
    if (has_credit && SendBytesToRouted(routing, bytes)) {
      subscription.sent_state = entry.version();
    } else {
      subscription.is_state_behind = true;
      subscription.starved_since_ns = core::MonotonicNow_ns();
    }
  }
}

void BusThread::AppendEvent(const core::Event& event) {
  oos::Control control;
  oos::EventItem* item = control.mutable_event();
  item->set_sequence(event_log_.newest() + 1);
  std::string bytes;
  EncodeState(event, &bytes);
  item->mutable_event()->ParseFromString(bytes);
  event_log_.Append(EncodeControl(core_->identity, TopicClass::kEvent, control));
  for (auto& [routing, subscription] : subscriptions_) {
    if (subscription.events == nullptr) continue;
    subscription.events->sent = event_log_.newest() - subscription.events->start;
    PumpEvents(routing, subscription);
  }
}

void BusThread::PumpEvents(const std::string& routing, Subscription& subscription) {
  if (!subscription.wants_events || subscription.is_evicted) return;
  if (subscription.sent_event + 1 < event_log_.oldest()) {  // the log has moved past it
    RewindEvents(subscription, subscription.sent_event);
    if (!AckSubscription(routing, subscription)) return;
  }
  while (subscription.sent_event < event_log_.newest() && subscription.HasEventCredit() &&
         SendBytesToRouted(routing, event_log_.At(subscription.sent_event + 1))) {
    ++subscription.sent_event;
  }
}

// Adds the total of each reliable topic and, in turn, some accounts for observers to a heartbeat.
void BusThread::AddCounts(oos::Heartbeat* heartbeat) {
  const auto add = [heartbeat](std::uint32_t topic, std::uint64_t count) {
    oos::TopicCount* total = heartbeat->add_counts();
    total->set_topic(topic);
    total->set_count(count);
  };
  add(TopicId(kEventTopic), event_log_.newest());
  for (const auto& [topic, count] : own_counts_) add(topic, count);

  const Account events = core_->book.Total(kEventTopic, true);
  core_->events_sent.store(events.sent, std::memory_order_relaxed);
  core_->events_dropped.store(events.dropped_in_all(), std::memory_order_relaxed);

  const std::vector<Account> all = AllAccounts(*core_);
  const std::vector<Account> accounts = MergeByName(all);
  for (std::size_t i = 0; i < std::min(accounts.size(), kAccountsPerHeartbeat); ++i) {
    const Account& account = accounts[next_account_++ % accounts.size()];
    oos::AccountFigures* figures = heartbeat->add_accounts();
    figures->set_topic(TopicId(account.topic));
    figures->set_peer(account.peer.empty() ? 0 : TopicId(account.peer));
    figures->set_is_writer(account.is_writer);
    figures->set_sent(account.sent);
    figures->set_received(account.received);
    figures->set_dropped(account.dropped_in_all());
    std::uint64_t sent = 0, instance = 0;
    if (!FindPresentLife(*core_, all, account, &sent, &instance)) continue;
    figures->set_life_sent(sent);
    figures->set_peer_life(static_cast<std::uint32_t>(instance));
  }
}

}  // namespace bus::detail
