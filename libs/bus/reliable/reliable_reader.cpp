// The reading end of STATE and EVENT: what this node reads from its peers. All on the bus thread, with the node's mutex
// held.
//
//   subscribe (last event received) -> ack (start of the accounts), snapshot -> deltas, events -> acknowledgements
//
// Deltas and events have consecutive sequence numbers, so a gap shows at the next one, or by the totals in the writer's
// heartbeats. Lost events are retransmitted in order from the writer's log; a lost delta is repaired by a snapshot.

#include <algorithm>

#include "bus/bus_thread.hpp"
#include "core/clock.hpp"

namespace bus::detail {
namespace {

// Several round trips of a slow network, so that a SUBSCRIBE that is only late is not repeated; and the pause that an
// evicted reader gets to catch up.
constexpr std::int64_t kResubscribeAfter_ns = 300 * core::kMillisecond_ns;
// Four heartbeats: a sequence gap that lasts longer is a loss, not a message still under way.
constexpr std::int64_t kBehindTooLong_ns = 200 * core::kMillisecond_ns;
// One retransmission arrives before the next one is requested.
constexpr std::int64_t kBetweenRepairs_ns = 50 * core::kMillisecond_ns;
constexpr std::uint64_t kAckEvery = kEventCredit / 4;  // within a burst: the writer must not run out of credit
// Room for a step thread that stalls. Events beyond it are retransmitted later; of STATE the newest value of each key
// stays.
constexpr std::size_t kMaxEventsForStep = 2'000;
constexpr std::size_t kMaxStatesForStep = 1'000;

}  // namespace

bool BusThread::ReadsFrom(const Peer& peer) const {
  for (const oos::TopicDeclaration& topic : peer.record.topics()) {
    if (!topic.is_written() || topic.topic_class() != static_cast<std::uint32_t>(TopicClass::kState)) continue;
    if (core_->IsObserved(topic.name())) return true;
    for (const auto& receiver : core_->state_receivers) {
      if (receiver->topic == topic.name()) return true;
    }
  }
  return false;
}

// The account of the peer's events; null until it has acknowledged the subscription.
Account* BusThread::EventsOf(const Peer& peer) {
  static const std::uint32_t id = TopicId(kEventTopic);
  return core_->book.Find(id, peer.record.instance(), false);
}

// The last event that is settled: received, or given up.
std::uint64_t BusThread::EventPlace(const Peer& peer) {
  const Account* events = EventsOf(peer);
  return events == nullptr ? 0 : events->start + events->received + events->dropped_in_all();
}

void BusThread::MaintainReading() {
  const std::int64_t now = core::MonotonicNow_ns();
  const bool wants_events = core_->reads_events || core_->IsObserved(kEventTopic);
  is_connecting_ = false;
  for (auto& [name, peer] : peers_) {
    PeerReading& reading = peer.reading;
    if (peer.has_left || (peer.was_heard && !StatusOf(peer).is_alive)) continue;
    const bool wants_state = ReadsFrom(peer);
    if (!wants_state && !wants_events) continue;
    if (reading.is_subscribed && wants_state) {
      if (reading.announced_version <= reading.state_version) {
        reading.state_behind_since_ns = now;
      } else if (now - reading.state_behind_since_ns > kBehindTooLong_ns) {
        reading.is_subscribed = false;
      }
    }
    if (reading.is_subscribed && wants_events) RequestMissing(peer);
    const bool is_full = reading.is_held && events_for_step_.size() >= kMaxEventsForStep / 2;
    if (!reading.is_subscribed && !is_full && now - reading.subscribed_ns >= kResubscribeAfter_ns) {
      Subscribe(peer, wants_state, wants_events);
    }
  }
}

void BusThread::Subscribe(Peer& peer, bool wants_state, bool wants_events) {
  oos::Control control;
  oos::Subscribe* subscribe = control.mutable_subscribe();
  subscribe->set_name(core_->options.name);
  subscribe->set_instance(core_->instance);
  subscribe->set_wants_state(wants_state);
  subscribe->set_wants_events(wants_events);
  AddReadings(peer, subscribe->mutable_readings());
  if (SendToPeer(peer, control)) {
    peer.reading.subscribed_ns = core::MonotonicNow_ns();
  } else {
    is_connecting_ = is_connecting_ || !peer.was_heard || StatusOf(peer).is_alive;  // retried soon
  }
}

void BusThread::AddReadings(const Peer& peer, google::protobuf::RepeatedPtrField<oos::Reading>* readings) {
  const auto add = [&](const std::string& topic) {
    const Account* account = core_->book.Find(TopicId(topic), peer.record.instance(), false);
    if (account == nullptr) return;
    oos::Reading* reading = readings->Add();
    reading->set_topic(TopicId(topic));
    reading->set_start(account->start);
    reading->set_received(account->received);
    reading->set_dropped(account->dropped_in_all());
  };
  add(kEventTopic);
  for (const oos::TopicDeclaration& topic : peer.record.topics()) {
    if (topic.is_written() && topic.topic_class() == static_cast<std::uint32_t>(TopicClass::kState)) add(topic.name());
  }
}

// Requests a retransmission of events that were left out because the step thread's queue was full, and of lost events
// that no later event reveals as a gap.
void BusThread::RequestMissing(Peer& peer) {
  PeerReading& reading = peer.reading;
  const std::int64_t now = core::MonotonicNow_ns();
  const Account* events = EventsOf(peer);
  if (events == nullptr) return;
  const std::uint64_t place = EventPlace(peer);
  if (place != reading.seen_event || place >= events->start + events->sent) {
    reading.seen_event = place;
    reading.seen_event_ns = now;
  }
  const bool has_room = events_for_step_.size() < kMaxEventsForStep / 2;
  const bool is_missing = now - reading.seen_event_ns > kBehindTooLong_ns;
  if (!has_room || (!reading.is_held && !is_missing) || now - reading.resend_requested_ns < kBetweenRepairs_ns) return;
  reading.is_held = false;
  reading.resend_requested_ns = now;
  Acknowledge(peer, true);
}

void BusThread::ReceiveFromPeer(Peer& peer) {
  zmq::message_t message;
  bool is_ack_due = false;
  while (peer.dealer.recv(message, zmq::recv_flags::dontwait)) {
    const std::span<const std::uint8_t> bytes(message.data<std::uint8_t>(), message.size());
    if (TakeDetoured(bytes)) continue;
    oos::Control control;
    if (!DecodeControl(bytes, core_->identity.session, &control)) {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    switch (control.body_case()) {
      case oos::Control::kSubscribeAck:
        TakeSubscribeAck(peer, control.subscribe_ack());
        is_ack_due = true;  // the writer has had no acknowledgement for a while, or ever
        break;
      case oos::Control::kStateSnapshot:
        TakeSnapshot(peer, control.state_snapshot());
        break;
      case oos::Control::kStateDelta:
        TakeDelta(peer, control.state_delta());
        break;
      case oos::Control::kEvent:
        TakeEvent(peer, control.event());
        break;
      case oos::Control::kEviction:  // waits before it subscribes again: it needs time to catch up
        peer.reading.is_subscribed = false;
        peer.reading.subscribed_ns = core::MonotonicNow_ns();
        break;
      case oos::Control::kParameterReply:
        TakeReply(peer, control.parameter_reply());
        break;
      default:
        core_->refused.fetch_add(1, std::memory_order_relaxed);
    }
    const PeerReading& reading = peer.reading;
    if (EventPlace(peer) >= reading.acked_event + kAckEvery || reading.state_version >= reading.acked_state + kAckEvery)
      Acknowledge(peer, false);
  }
  if (is_ack_due || EventPlace(peer) > peer.reading.acked_event ||
      peer.reading.state_version > peer.reading.acked_state) {
    Acknowledge(peer, false);
  }
}

void BusThread::Acknowledge(Peer& peer, bool resend) {
  oos::Control control;
  oos::EventAck* ack = control.mutable_event_ack();
  ack->set_sequence(EventPlace(peer));
  ack->set_resend(resend);
  ack->set_state_version(peer.reading.state_version);
  ack->set_instance(core_->instance);
  AddReadings(peer, ack->mutable_readings());
  if (!SendToPeer(peer, control)) return;
  peer.reading.acked_event = ack->sequence();
  peer.reading.acked_state = ack->state_version();
}

void BusThread::TakeSubscribeAck(Peer& peer, const oos::SubscribeAck& ack) {
  PeerReading& reading = peer.reading;
  reading.is_subscribed = true;
  reading.is_held = false;
  reading.state_behind_since_ns = core::MonotonicNow_ns();
  const auto open = [&](const std::string& topic, TopicClass topic_class) {
    for (const oos::Reading& start : ack.starts()) {
      if (start.topic() == TopicId(topic)) {
        core_->book.Open(topic, topic_class, peer.record.name(), peer.record.instance(), false, start.start());
      }
    }
  };
  open(kEventTopic, TopicClass::kEvent);
  for (const oos::TopicDeclaration& topic : peer.record.topics()) {
    if (topic.is_written() && topic.topic_class() == static_cast<std::uint32_t>(TopicClass::kState)) {
      open(topic.name(), TopicClass::kState);
    }
  }
  Account* events = EventsOf(peer);
  const std::uint64_t next = EventPlace(peer) + 1;
  if (events == nullptr || ack.next_event() <= next) return;
  // It was away for longer than the writer's log reaches back.
  const std::uint64_t missed = ack.next_event() - next;
  events->dropped[static_cast<std::size_t>(DropReason::kOverrun)] += missed;
  events->sent = std::max(events->sent, events->received + events->dropped_in_all());
  Announce("events_missed", peer.record.name() + ": " + std::to_string(missed));
}

void BusThread::TakeSnapshot(Peer& peer, const oos::StateSnapshot& snapshot) {
  PeerReading& reading = peer.reading;
  if (!reading.is_subscribed || (reading.has_snapshot && snapshot.version() < reading.state_version)) return;
  if (!reading.has_snapshot) {  // values of an earlier writer are void
    for (std::uint32_t slot = 0; slot < core_->state_receivers.size(); ++slot) {
      for (const oos::TopicCount& count : snapshot.counts()) {
        if (TopicId(core_->state_receivers[slot]->topic) == count.topic()) PushState({slot, {}, {}, 0, true});
      }
    }
  }
  // In the order in which they were set: a step thread may see the first half before the second.
  std::vector<const oos::StateEntry*> entries;
  for (const oos::StateEntry& entry : snapshot.entries()) {
    if (!reading.has_snapshot || entry.version() > reading.state_version) entries.push_back(&entry);
  }
  std::sort(entries.begin(), entries.end(), [](const auto* a, const auto* b) { return a->version() < b->version(); });
  for (const oos::StateEntry* entry : entries) TakeState(peer, *entry);
  reading.has_snapshot = true;
  reading.state_version = snapshot.version();
  for (const oos::TopicCount& count : snapshot.counts()) {
    Account* account = core_->book.Find(count.topic(), peer.record.instance(), false);
    if (account == nullptr || count.count() < account->start) continue;
    const std::uint64_t settled = account->received + account->dropped_in_all();
    const std::uint64_t counted = count.count() - account->start;
    if (counted > settled) account->dropped[static_cast<std::size_t>(DropReason::kSuperseded)] += counted - settled;
    account->sent = std::max(account->sent, counted);
  }
}

void BusThread::TakeDelta(Peer& peer, const oos::StateEntry& entry) {
  PeerReading& reading = peer.reading;
  if (entry.version() <= reading.state_version) return;  // in the snapshot already
  Account* account = core_->book.Find(TopicId(entry.topic()), peer.record.instance(), false);
  if (account == nullptr || entry.version() != reading.state_version + 1) {
    reading.is_subscribed = false;
    reading.subscribed_ns = 0;
    return;
  }
  reading.state_version = entry.version();
  ++account->received;
  account->sent = std::max(account->sent, entry.count() - account->start);
  TakeState(peer, entry);
}

void BusThread::TakeState(Peer& peer, const oos::StateEntry& entry) {
  for (std::uint32_t slot = 0; slot < core_->state_receivers.size(); ++slot) {
    if (core_->state_receivers[slot]->topic != entry.topic()) continue;
    PushState({slot, entry.key(), entry.value(), entry.version(), false});
    core_->state_receivers[slot]->received.fetch_add(1, std::memory_order_relaxed);
  }
  if (core_->IsObserved(entry.topic())) {
    const TopicRule* rule = FindTopicRule(entry.topic());
    core_->AddObservation({entry.topic(), TopicClass::kState, rule != nullptr ? rule->type : MessageType::kNone,
                           peer.record.name(), entry.version(), 0, core::MonotonicNow_ns(), entry.value().size(), 0, 1,
                           entry.value()});
  }
}

// A step thread that was stalled for long gets the newest value of each key, not every value in between.
void BusThread::PushState(StateItem item) {
  if (states_for_step_.size() >= kMaxStatesForStep) {
    std::erase_if(states_for_step_, [&item](const StateItem& other) {
      return other.slot == item.slot && !other.is_reset && (item.is_reset || other.key == item.key);
    });
  }
  states_for_step_.push_back(std::move(item));
}

void BusThread::TakeEvent(Peer& peer, const oos::EventItem& item) {
  Account* events = EventsOf(peer);
  if (events == nullptr) return;
  const std::uint64_t next = EventPlace(peer) + 1;
  if (item.sequence() < next) return;  // repeated
  if (item.sequence() > events->start) events->sent = std::max(events->sent, item.sequence() - events->start);
  if (core_->reads_events && events_for_step_.size() >= kMaxEventsForStep) {
    peer.reading.is_held = true;
    return;
  }
  if (item.sequence() > next) {
    const std::int64_t now = core::MonotonicNow_ns();
    if (now - peer.reading.resend_requested_ns < kBetweenRepairs_ns) return;
    peer.reading.resend_requested_ns = now;
    Acknowledge(peer, true);
    return;
  }
  ++events->received;
  core_->events_received.fetch_add(1, std::memory_order_relaxed);
  if (core_->reads_events) DecodeState(item.event().SerializeAsString(), &events_for_step_.emplace_back());
  if (core_->IsObserved(kEventTopic)) {
    core_->AddObservation({kEventTopic, TopicClass::kEvent, MessageType::kEvent, peer.record.name(), item.sequence(),
                           item.event().time_ns(), core::MonotonicNow_ns(), item.ByteSizeLong(), 0, 1,
                           item.event().SerializeAsString()});
  }
}

// The writer's totals: the excess over what has arrived is under way, or lost.
void BusThread::TakeCounts(Peer& peer, const oos::Heartbeat& heartbeat) {
  peer.reading.announced_version = heartbeat.state_version();
  for (const oos::TopicCount& count : heartbeat.counts()) {
    Account* account = core_->book.Find(count.topic(), peer.record.instance(), false);
    if (account != nullptr && count.count() > account->start) {
      account->sent = std::max(account->sent, count.count() - account->start);
    }
  }
}

// The accounts that the peer reports, for observers. Names come as hashes; unknown ones are left out.
void BusThread::TakeAccounts(const oos::Heartbeat& heartbeat, PeerStatus* status) const {
  for (const oos::AccountFigures& figures : heartbeat.accounts()) {
    std::string topic = figures.topic() == TopicId(kEventTopic)       ? kEventTopic
                        : figures.topic() == TopicId(kParameterTopic) ? kParameterTopic
                                                                      : "";
    const auto known = core_->known_topics.find(figures.topic());
    if (known != core_->known_topics.end()) topic = known->second.name;
    std::string peer;
    for (const auto& [name, other] : core_->peers) {
      if (TopicId(name) == figures.peer()) peer = name;
    }
    if (core_->identity.node == figures.peer()) peer = core_->options.name;
    if (topic.empty() || (peer.empty() && figures.peer() != 0)) continue;
    const auto found =
        std::find_if(status->accounts.begin(), status->accounts.end(), [&](const ReportedAccount& entry) {
          return entry.topic == topic && entry.peer == peer && entry.is_writer == figures.is_writer();
        });
    ReportedAccount& account = found != status->accounts.end() ? *found : status->accounts.emplace_back();
    account = {topic,
               peer,
               figures.is_writer(),
               figures.sent(),
               figures.received(),
               figures.dropped(),
               figures.life_sent(),
               figures.peer_life(),
               core::MonotonicNow_ns()};
  }
}

bool BusThread::SendToPeer(Peer& peer, const oos::Control& control) {
  const auto bytes = EncodeControl(core_->identity, ClassOf(control), control);
  try {
    return peer.dealer.send(zmq::buffer(bytes), zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t&) {
    return false;
  }
}

void BusThread::FlushToStepThread() {
  while (!events_for_step_.empty()) {
    core::Event* slot = core_->events_in.BeginPush();
    if (slot == nullptr) break;
    *slot = events_for_step_.front();
    core_->events_in.EndPush();
    events_for_step_.pop_front();
  }
  while (!states_for_step_.empty()) {
    StateItem* slot = core_->states_in.BeginPush();
    if (slot == nullptr) break;
    *slot = states_for_step_.front();
    core_->states_in.EndPush();
    states_for_step_.pop_front();
  }
  while (!acks_for_step_.empty()) {
    ParameterAck* slot = core_->acks_in.BeginPush();
    if (slot == nullptr) break;
    *slot = acks_for_step_.front();
    core_->acks_in.EndPush();
    acks_for_step_.pop_front();
  }
}

}  // namespace bus::detail
