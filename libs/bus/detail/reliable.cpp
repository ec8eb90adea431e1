// The reliable classes: STATE, EVENT, SERVICE. All on the bus thread, with the node's mutex held.

#include <algorithm>

#include "bus/detail/bus_thread.hpp"
#include "core/clock.hpp"
#include "core/names.hpp"

namespace bus::detail {
namespace {

constexpr std::int64_t kAskAgainAfter_ns = 300 * kMillisecond_ns;
constexpr std::int64_t kBehindTooLong_ns = 200 * kMillisecond_ns;
constexpr std::int64_t kWaitForOwners_ns = 500 * kMillisecond_ns;
constexpr std::int64_t kWaitForCredit_ns = 100 * kMillisecond_ns;
constexpr std::uint64_t kAckEvery = kEventCredit / 4;  // within a burst: its end may be far
constexpr std::size_t kMaxEventsForStep = 2'000;

core::Event ToCore(const oos::Event& event) {
  return {event.time_ns(), event.source(), event.name(), event.detail()};
}

}  // namespace

// --- Reading side ---

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

// Subscribe first, then the owner answers with an ack and a snapshot, and deltas follow. What is not acknowledged is
// asked again; a gap in the versions is repaired by a new snapshot.
void BusThread::MaintainSubscriptions() {
  const std::int64_t now = core::MonotonicNow_ns();
  const bool wants_events = core_->reads_events || core_->IsObserved(kEventTopic);
  for (auto& [name, peer] : peers_) {
    if (peer.has_left || !StatusOf(peer).is_alive) continue;
    const bool wants_state = ReadsFrom(peer);
    if (!wants_state && !wants_events) continue;
    if (peer.is_subscribed && wants_state) {
      if (peer.told_version <= peer.state_version) {
        peer.behind_since_ns = now;
      } else if (now - peer.behind_since_ns > kBehindTooLong_ns) {
        peer.is_subscribed = false;
      }
    }
    if (peer.is_subscribed || now - peer.asked_ns < kAskAgainAfter_ns) continue;
    oos::Control control;
    oos::Subscribe* subscribe = control.mutable_subscribe();
    subscribe->set_name(core_->options.name);
    subscribe->set_instance(core_->instance);
    subscribe->set_wants_state(wants_state);
    subscribe->set_wants_events(wants_events);
    if (SendToPeer(peer, control)) peer.asked_ns = now;  // not connected yet: next round
  }
}

void BusThread::ReceiveFromPeer(Peer& peer) {
  zmq::message_t message;
  while (peer.dealer.recv(message, zmq::recv_flags::dontwait)) {
    oos::Control control;
    if (!DecodeControl({message.data<std::uint8_t>(), message.size()}, core_->identity.session, &control)) {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    switch (control.body_case()) {
      case oos::Control::kSubscribeAck: {
        peer.is_subscribed = true;
        peer.behind_since_ns = core::MonotonicNow_ns();
        const std::uint64_t next = control.subscribe_ack().next_event();
        if (peer.next_event != 0 && next > peer.next_event) {
          core_->events_dropped.fetch_add(next - peer.next_event, std::memory_order_relaxed);
        }
        peer.next_event = std::max(peer.next_event, next);
        break;
      }
      case oos::Control::kStateSnapshot:
        for (const oos::StateEntry& entry : control.state_snapshot().entries()) TakeState(peer, entry);
        peer.state_version = control.state_snapshot().version();
        break;
      case oos::Control::kStateDelta: {
        const oos::StateEntry& entry = control.state_delta();
        if (entry.version() <= peer.state_version) break;  // in the snapshot already
        if (entry.version() != peer.state_version + 1) {
          peer.is_subscribed = false;
          peer.asked_ns = 0;
          break;
        }
        peer.state_version = entry.version();
        TakeState(peer, entry);
        break;
      }
      case oos::Control::kEvent:
        TakeEvent(peer, control.event());
        if (peer.next_event > peer.acked_event + kAckEvery) AckEvents(peer);
        break;
      case oos::Control::kParameterReply: {
        const auto open = open_calls_.find(control.parameter_reply().request());
        if (open != open_calls_.end()) AnswerCall(open->second, peer.record.name(), control.parameter_reply());
        break;
      }
      default:
        core_->refused.fetch_add(1, std::memory_order_relaxed);
    }
  }
  if (peer.next_event > peer.acked_event + 1) AckEvents(peer);
}

void BusThread::AckEvents(Peer& peer) {
  oos::Control control;
  control.mutable_event_ack()->set_sequence(peer.next_event - 1);
  if (SendToPeer(peer, control)) peer.acked_event = peer.next_event - 1;
}

void BusThread::TakeState(Peer& peer, const oos::StateEntry& entry) {
  for (std::uint32_t slot = 0; slot < core_->state_receivers.size(); ++slot) {
    if (core_->state_receivers[slot]->topic != entry.topic()) continue;
    states_for_step_.push_back({slot, entry.key(), entry.value(), entry.version()});
    core_->state_receivers[slot]->received.fetch_add(1, std::memory_order_relaxed);
  }
  if (core_->IsObserved(entry.topic())) {
    const TopicRule* rule = FindTopicRule(entry.topic());
    core_->AddObservation({entry.topic(), TopicClass::kState, rule != nullptr ? rule->type : MessageType::kNone,
                           peer.record.name(), entry.version(), 0, core::MonotonicNow_ns(), entry.value().size(), 0, 1,
                           entry.value()});
  }
}

void BusThread::TakeEvent(Peer& peer, const oos::EventItem& item) {
  if (item.sequence() < peer.next_event) return;  // repeated
  if (peer.next_event != 0 && item.sequence() > peer.next_event) {
    core_->events_dropped.fetch_add(item.sequence() - peer.next_event, std::memory_order_relaxed);
  }
  peer.next_event = item.sequence() + 1;
  core_->events_received.fetch_add(1, std::memory_order_relaxed);
  if (core_->reads_events) {
    if (events_for_step_.size() < kMaxEventsForStep) {
      events_for_step_.push_back(ToCore(item.event()));
    } else {
      core_->events_dropped.fetch_add(1, std::memory_order_relaxed);
    }
  }
  if (core_->IsObserved(kEventTopic)) {
    core_->AddObservation({kEventTopic, TopicClass::kEvent, MessageType::kEvent, peer.record.name(), item.sequence(),
                           item.event().time_ns(), core::MonotonicNow_ns(), item.ByteSizeLong(), 0, 1,
                           item.event().SerializeAsString()});
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

// --- Owner's side ---

void BusThread::ReceiveFromRouter() {
  for (;;) {
    zmq::message_t routing, message;
    if (!router_.recv(routing, zmq::recv_flags::dontwait)) return;
    if (!routing.more() || !router_.recv(message, zmq::recv_flags::dontwait)) continue;
    bool is_longer = message.more();
    while (is_longer) {  // we send two frames; whoever sends more is not one of us
      zmq::message_t rest;
      if (!router_.recv(rest, zmq::recv_flags::dontwait)) break;
      is_longer = rest.more();
    }
    oos::Control control;
    if (!DecodeControl({message.data<std::uint8_t>(), message.size()}, core_->identity.session, &control)) {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    const std::string from = routing.to_string();
    if (control.has_subscribe()) {
      TakeSubscribe(from, control.subscribe());
    } else if (control.has_event_ack()) {
      const auto found = subscriptions_.find(from);
      if (found == subscriptions_.end()) continue;
      Subscription& subscription = found->second;
      subscription.acked_event = std::clamp(control.event_ack().sequence(), subscription.acked_event,
                                            std::max(subscription.sent_event, subscription.acked_event));
      subscription.is_out_of_credit = false;
      subscription.starved_since_ns = 0;
    } else if (control.has_parameter_request()) {
      TakeRequest(from, control.parameter_request());
    } else {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
    }
  }
}

void BusThread::TakeSubscribe(const std::string& routing, const oos::Subscribe& subscribe) {
  // A restarted reader comes with a new routing id; what the old one had is of no use any more.
  std::erase_if(subscriptions_, [&](const auto& item) {
    return item.second.name == subscribe.name() && item.second.instance != subscribe.instance();
  });
  Subscription& subscription = subscriptions_[routing];
  subscription.name = subscribe.name();
  subscription.instance = subscribe.instance();
  subscription.wants_state = subscribe.wants_state();
  subscription.wants_events = subscribe.wants_events();

  oos::Control ack;
  ack.mutable_subscribe_ack()->set_instance(core_->instance);
  ack.mutable_subscribe_ack()->set_next_event(subscription.next_event);
  oos::Control snapshot;
  snapshot.mutable_state_snapshot()->set_version(own_state_version_);
  for (const auto& [key, entry] : retained_) *snapshot.mutable_state_snapshot()->add_entries() = entry;
  // What does not get through is asked for again. The subscription stays: were its events numbered from 1 again, the
  // reader would take them for repetitions.
  if (SendToRouted(routing, ack) && subscribe.wants_state()) SendToRouted(routing, snapshot);
}

void BusThread::TakeRequest(const std::string& routing, const oos::ParameterRequest& request) {
  oos::Control reply;
  reply.mutable_parameter_reply()->set_request(request.request());
  const std::vector<std::string>& names = core_->parameter_names;
  if (std::find(names.begin(), names.end(), request.change().name()) == names.end()) {
    reply.mutable_parameter_reply()->set_why(core_->options.name +
                                             (names.empty() ? " owns no parameters"
                                                            : " has no parameter '" + request.change().name() + "'; " +
                                                                  core::SuggestName(request.change().name(), names)));
    SendToRouted(routing, reply);
    return;
  }
  if (request.change().manner() > static_cast<std::uint32_t>(core::ChangeManner::kWhenSeparated)) {
    reply.mutable_parameter_reply()->set_why(core_->options.name + " does not know this manner of changing");
    SendToRouted(routing, reply);
    return;
  }
  ParameterItem* slot = core_->parameters_in.BeginPush();
  if (slot == nullptr) {
    reply.mutable_parameter_reply()->set_why(core_->options.name +
                                             " has too many changes waiting; is its loop running?");
    SendToRouted(routing, reply);
    return;
  }
  slot->ticket = next_ticket_++;
  slot->change.name = request.change().name();
  slot->change.value = request.change().value();
  slot->change.manner = static_cast<core::ChangeManner>(request.change().manner());
  slot->change.ramp_s = request.change().ramp_s();
  tickets_[slot->ticket] = {routing, request.request()};
  core_->parameters_in.EndPush();
}

bool BusThread::SendToRouted(const std::string& routing, const oos::Control& control) {
  const auto bytes = EncodeControl(core_->identity, ClassOf(control), control);
  try {
    if (!router_.send(zmq::buffer(routing), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) return false;
    return router_.send(zmq::buffer(bytes), zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t&) {  // EHOSTUNREACH: it is gone
    return false;
  }
}

// --- From and to the step thread ---

void BusThread::DrainStepThread() {
  while (const StateItem* item = core_->states_out.Front()) {
    SendState(*item);
    core_->states_out.EndPop();
  }
  DrainEvents();
  while (const ParameterAnswer* answer = core_->answers_out.Front()) {
    const auto ticket = tickets_.find(answer->ticket);
    if (ticket != tickets_.end()) {
      oos::Control control;
      oos::ParameterReply* reply = control.mutable_parameter_reply();
      reply->set_request(ticket->second.second);
      reply->set_is_accepted(answer->is_accepted);
      reply->set_tick(answer->tick);
      reply->set_why(answer->why);
      reply->set_injected_j(answer->injected_J);
      reply->set_is_pending(answer->is_pending);
      SendToRouted(ticket->second.first, control);
      tickets_.erase(ticket);
    }
    core_->answers_out.EndPop();
  }
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
    if (!is_stopping_.load() && IsWaitingForCredit()) return;
    SendEvent(*event);
    core_->events_out.EndPop();
  }
  core_->Wake();
}

// A reader that keeps up has its credit back as soon as its acknowledgement has travelled, which takes its time on a
// busy machine. Until then events stay in the ring, and a full ring is told to who emits. Only a reader that does not
// acknowledge for kWaitForCredit_ns is slow: it loses events from then on and holds nobody up until it is back.
bool BusThread::IsWaitingForCredit() {
  const std::int64_t now = core::MonotonicNow_ns();
  bool is_waiting = false;
  for (auto& [routing, subscription] : subscriptions_) {
    if (!subscription.wants_events || subscription.is_out_of_credit || subscription.HasCredit()) continue;
    if (FindReader(subscription) == nullptr) continue;
    if (subscription.starved_since_ns == 0) subscription.starved_since_ns = now;
    is_waiting = is_waiting || now - subscription.starved_since_ns < kWaitForCredit_ns;
  }
  return is_waiting;
}

void BusThread::SendState(const StateItem& item) {
  StateSender& sender = *core_->state_senders[item.slot];
  oos::StateEntry& entry = retained_[{sender.topic, item.key}];
  entry.set_topic(sender.topic);
  entry.set_key(item.key);
  entry.set_value(item.bytes);
  entry.set_version(++own_state_version_);
  oos::Control control;
  *control.mutable_state_delta() = entry;
  for (auto subscription = subscriptions_.begin(); subscription != subscriptions_.end();) {
    // A reader that cannot be reached finds the gap by the version in our heartbeat and asks for a snapshot.
    if (subscription->second.wants_state && SendToRouted(subscription->first, control)) {
      sender.sent.fetch_add(1, std::memory_order_relaxed);
    }
    ++subscription;
  }
}

void BusThread::SendEvent(const core::Event& event) {
  oos::Control control;
  oos::EventItem* item = control.mutable_event();
  item->mutable_event()->set_time_ns(event.time_ns);
  item->mutable_event()->set_source(event.source);
  item->mutable_event()->set_name(event.name);
  item->mutable_event()->set_detail(event.detail);
  for (auto& [routing, subscription] : subscriptions_) {
    if (!subscription.wants_events) continue;
    item->set_sequence(subscription.next_event);
    ++subscription.next_event;  // a dropped event leaves a gap that the reader sees
    if (subscription.HasCredit() && SendToRouted(routing, control)) {
      subscription.sent_event = item->sequence();
      core_->events_sent.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    Peer* reader = FindReader(subscription);
    if (reader == nullptr) continue;  // nobody is there to miss it
    core_->events_dropped.fetch_add(1, std::memory_order_relaxed);
    ++StatusOf(*reader).events_dropped;
    if (!subscription.is_out_of_credit) {
      subscription.is_out_of_credit = true;
      Announce("events_dropped", subscription.name);
    }
  }
}

void BusThread::OpenParameterCall(const ParameterCall& call) {
  OpenCall& open = open_calls_[call.request];
  open.call = call;
  open.created_ns = core::MonotonicNow_ns();
}

// Sends a call when its owners are there, and ends it when all have answered or time is up.
void BusThread::ServeCalls() {
  const std::int64_t now = core::MonotonicNow_ns();
  for (auto item = open_calls_.begin(); item != open_calls_.end();) {
    OpenCall& open = item->second;
    const ParameterCall& call = open.call;
    if (open.asked.empty()) {
      bool are_all_alive = true;
      std::vector<Peer*> owners;
      for (auto& [name, peer] : peers_) {
        const bool is_owner = call.owner.empty() ? peer.record.owns_parameters() : call.owner == name;
        if (!is_owner || peer.has_left) continue;
        if (StatusOf(peer).is_alive) {
          owners.push_back(&peer);
        } else {
          are_all_alive = are_all_alive && peer.was_heard;  // just started: give it a moment
        }
      }
      if (are_all_alive || now - open.created_ns > kWaitForOwners_ns) {
        oos::Control control;
        oos::ParameterRequest* request = control.mutable_parameter_request();
        request->set_request(call.request);
        request->set_caller(core_->options.name);
        request->mutable_change()->set_name(call.change.name);
        request->mutable_change()->set_value(call.change.value);
        request->mutable_change()->set_manner(static_cast<std::uint32_t>(call.change.manner));
        request->mutable_change()->set_ramp_s(call.change.ramp_s);
        for (Peer* owner : owners) {
          if (SendToPeer(*owner, control)) open.asked[owner->record.name()] = false;
        }
      }
    }
    const bool is_late = now >= call.deadline_ns;
    for (auto& [name, has_answered] : open.asked) {
      const auto peer = peers_.find(name);
      const bool is_dead = peer == peers_.end() || !StatusOf(peer->second).is_alive;
      if (has_answered || (!is_dead && !is_late)) continue;
      oos::ParameterReply reply;
      reply.set_why(name + (is_dead ? " died before it answered" : " did not answer in time"));
      AnswerCall(open, name, reply);
    }
    if (open.asked.empty() && is_late) {
      std::string alive;
      for (const auto& [name, status] : core_->peers) {
        if (status.is_alive) alive += (alive.empty() ? "" : ", ") + name;
      }
      oos::ParameterReply reply;
      reply.set_why((call.owner.empty() ? "no live node owns parameters" : "no live node is called " + call.owner) +
                    "; alive: " + (alive.empty() ? "none" : alive));
      AnswerCall(open, call.owner, reply);
    }
    const bool is_done = !open.asked.empty() && std::all_of(open.asked.begin(), open.asked.end(),
                                                            [](const auto& asked) { return asked.second; });
    if (is_done && call.is_waited_for) core_->finished_calls[call.request] = open.result;
    item = is_done ? open_calls_.erase(item) : std::next(item);
  }
}

void BusThread::AnswerCall(OpenCall& open, const std::string& owner, const oos::ParameterReply& reply) {
  if (open.asked.count(owner) != 0 && open.asked[owner]) return;  // answered already
  open.asked[owner] = true;
  const ParameterAck ack{open.call.request, owner, reply.is_accepted(), reply.tick(), reply.why(), reply.injected_j(),
                         reply.is_pending()};
  if (!open.call.is_waited_for) {
    acks_for_step_.push_back(ack);
    return;
  }
  // One that accepts is enough; otherwise all reasons are told.
  if (ack.is_accepted && !open.result.is_accepted) {
    open.result = ack;
  } else if (!ack.is_accepted && !open.result.is_accepted) {
    const std::string before = open.result.why.empty() ? std::string() : open.result.why + "; ";
    open.result = ack;
    open.result.why = before + ack.why;
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
