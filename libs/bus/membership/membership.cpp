// Membership: this node's HELLO, the registry's roster, and the admission of peers.

#include <unistd.h>

#include <algorithm>
#include <set>

#include "bus/bus_thread.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"

namespace bus::detail {

oos::NodeRecord BusThread::OwnRecord(bool with_schemas) const {
  oos::NodeRecord record;
  record.set_name(core_->options.name);
  record.set_instance(core_->instance);
  record.set_boot(core_->identity.boot);
  record.set_session(core_->identity.session);
  record.set_protocol_version(kProtocolVersion);
  record.set_process_id(static_cast<std::uint32_t>(getpid()));
  record.set_data_endpoint(core_->data_socket.endpoint());
  record.set_heartbeat_endpoint(core_->heartbeat_socket.endpoint());
  record.set_router_endpoint(router_endpoint_);
  record.set_machine_id(machine_id_);
  record.set_multicast_group(core_->options.multicast);
  record.set_is_observer(core_->options.is_observer);
  record.set_owns_parameters(!core_->parameter_names.empty());
  record.set_reads_events(core_->reads_events);
  for (const std::string& pattern : core_->observed_patterns) record.add_observed_patterns(pattern);
  std::set<MessageType> types;
  const auto declare = [&](const std::string& topic, TopicClass topic_class, MessageType type, bool is_written) {
    oos::TopicDeclaration* declaration = record.add_topics();
    declaration->set_name(topic);
    declaration->set_topic_class(static_cast<std::uint32_t>(topic_class));
    declaration->set_message_type(static_cast<std::uint32_t>(type));
    declaration->set_schema_digest(SchemaOf(type).digest);
    declaration->set_is_written(is_written);
    types.insert(type);
  };
  for (const auto& sender : core_->senders) declare(sender->topic, TopicClass::kLatest, sender->type, true);
  for (const auto& receiver : core_->receivers) {
    declare(receiver->topic, TopicClass::kLatest, receiver->type, false);
    record.mutable_topics(record.topics_size() - 1)->set_keeps_history(receiver->keeps_history());
  }
  for (const auto& sender : core_->state_senders) declare(sender->topic, TopicClass::kState, sender->type, true);
  for (const auto& receiver : core_->state_receivers)
    declare(receiver->topic, TopicClass::kState, receiver->type, false);
  if (with_schemas) {
    for (const MessageType type : types) {
      oos::Schema* schema = record.add_schemas();
      schema->set_digest(SchemaOf(type).digest);
      schema->set_canonical(SchemaOf(type).canonical);
    }
  }
  return record;
}

bool BusThread::SendHello(bool is_goodbye) {
  oos::Control control;
  *control.mutable_hello()->mutable_node() = OwnRecord(true);
  control.mutable_hello()->set_known_roster(roster_version_);
  control.mutable_hello()->set_is_goodbye(is_goodbye);
  control.mutable_hello()->set_takes_over(core_->options.takes_over && !core_->is_welcomed);
  control.mutable_hello()->set_is_member(core_->is_welcomed);
  const auto bytes = EncodeControl(core_->identity, TopicClass::kControl, control);
  try {
    return registry_.send(zmq::buffer(bytes), zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t&) {
    return false;
  }
}

// A sender chooses its routing id, "<name>#<instance>", freely; its key is proven.
bool BusThread::IsAdmitted(const std::string& routing, zmq::message_t& message) const {
  const std::size_t mark = routing.rfind('#');
  const std::uint64_t instance = mark == std::string::npos ? 0 : std::strtoull(routing.c_str() + mark + 1, nullptr, 10);
  if (fenced_.count(instance) != 0) {
    core_->refused_fenced.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (!core_->keys || IsKeyFor(Gate::KeyNameOf(message), routing.substr(0, mark))) return true;
  core_->refused.fetch_add(1, std::memory_order_relaxed);
  return false;
}

void BusThread::ReceiveFromRegistry() {
  zmq::message_t message;
  while (registry_.recv(message, zmq::recv_flags::dontwait)) {
    oos::Control control;
    if (!DecodeControl({message.data<std::uint8_t>(), message.size()}, core_->identity.session, &control)) {
      core_->refused.fetch_add(1, std::memory_order_relaxed);
    } else if (control.has_roster()) {
      TakeRoster(control.roster());
      core_->is_welcomed = true;
    } else if (control.has_refusal() && control.refusal().is_fenced()) {
      TakeFence(control.refusal().why());
    } else if (control.has_refusal()) {
      if (core_->is_welcomed && core_->refusal != control.refusal().why()) {
        Announce("registry_refused", control.refusal().why());
      }
      core_->refusal = control.refusal().why();
    }
  }
}

void BusThread::TakeRoster(const oos::Roster& roster) {
  core_->session_key = roster.session_key();
  if (!core_->is_welcomed && roster.boot() != 0) core_->identity.boot = roster.boot();
  if (roster.is_unchanged()) return;
  roster_version_ = roster.version();
  for (const std::uint64_t instance : roster.fenced()) FenceOff(instance);
  for (const oos::NodeRecord& record : roster.nodes()) {
    // A roster only adds peers: a registry that was restarted does not know all of them yet.
    if (record.name() == core_->options.name || gone_.count(record.instance()) != 0) continue;
    if (fenced_.count(record.instance()) != 0) continue;
    const auto known = peers_.find(record.name());
    if (known == peers_.end()) {
      AddPeer(record, 0);
    } else if (known->second.record.instance() != record.instance() && record.boot() > known->second.record.boot()) {
      if (StatusOf(known->second).is_alive) Lose(known->second, false);
      ForgetReader(record.name(), known->second.record.instance());
      const std::uint32_t restarts = StatusOf(known->second).restarts + 1;
      peers_.erase(known);
      AddPeer(record, restarts);
    }
  }
  UpdateSenders();
}

// Another instance has replaced it. One of the same name also replaces its record, see TakeRoster.
void BusThread::FenceOff(std::uint64_t instance) {
  if (instance == core_->instance || !fenced_.insert(instance).second) return;
  for (auto& [name, peer] : peers_) {
    if (peer.record.instance() != instance) continue;
    Lose(peer, false);
    Announce("node_fenced", name);
    peer.dealer.close();
    try {  // nothing from it is read any more
      peer.dealer = zmq::socket_t(context_, zmq::socket_type::dealer);
      peer.dealer.set(zmq::sockopt::linger, 0);
    } catch (const zmq::error_t&) {
    }
  }
  std::erase_if(subscriptions_, [instance](const auto& item) { return item.second.instance == instance; });
  core_->book.CloseAll(instance);  // its subscription may have come before the roster that names it
}

// This node was superseded while it was suspended or cut off. It sends nothing any more.
void BusThread::TakeFence(const std::string& why) {
  if (is_fenced_) return;
  is_fenced_ = true;
  core_->refusal = why;
  Announce("fenced", why);
  subscriptions_.clear();
  are_subscribers_outdated_ = true;
}

void BusThread::AddPeer(const oos::NodeRecord& record, std::uint32_t restarts) {
  Peer peer;
  peer.record = record;
  if (!ParseEndpoint(record.data_endpoint(), &peer.data_address) ||
      !ParseEndpoint(record.heartbeat_endpoint(), &peer.heartbeat_address)) {
    core_->refused.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  try {
    peer.dealer = zmq::socket_t(context_, zmq::socket_type::dealer);
    peer.dealer.set(zmq::sockopt::routing_id, core_->options.name + "#" + std::to_string(core_->instance));
    peer.dealer.set(zmq::sockopt::linger, 0);
    peer.dealer.set(zmq::sockopt::immediate, true);  // no queue grows for a peer that is gone
    peer.dealer.set(zmq::sockopt::reconnect_ivl, 20);
    peer.dealer.set(zmq::sockopt::reconnect_ivl_max, 500);
    gate_.GuardConnection(&peer.dealer, record.public_key());
    peer.dealer.connect(record.router_endpoint());
  } catch (const zmq::error_t&) {
    core_->refused.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  peer.since_ns = core::MonotonicNow_ns();
  peer.events_before = event_log_.newest();
  PeerStatus status;
  status.name = record.name();
  status.instance = record.instance();
  status.process_id = record.process_id();
  status.is_observer = record.is_observer();
  status.restarts = restarts;
  if (IsElsewhere(peer)) status.clock_bound_ns = status.largest_clock_bound_ns = kUnknownBound_ns;
  if (const auto earlier = core_->peers.find(record.name()); earlier != core_->peers.end()) {
    status.largest_clock_bound_ns = earlier->second.largest_clock_bound_ns;  // over the whole run, restarts included
  }
  status.udp_endpoint = record.data_endpoint();
  status.router_endpoint = record.router_endpoint();
  for (const oos::TopicDeclaration& topic : record.topics()) {
    const std::uint32_t id = TopicId(topic.name());
    const auto type = static_cast<MessageType>(topic.message_type());
    peer.topic_slots[{id, topic.is_written()}] = status.counters.topics.size();
    status.counters.topics.push_back(
        {topic.name(), static_cast<TopicClass>(topic.topic_class()), topic.is_written(), 0, 0, 0, 0});
    if (!topic.is_written()) continue;
    core_->known_topics[id] = {topic.name(), type, record.name()};
    for (const auto& receiver : core_->receivers) {
      // The registry admitted both, so their schemas are compatible.
      if (receiver->id == id) receiver->other_digest.store(topic.schema_digest(), std::memory_order_relaxed);
    }
  }
  core_->peers[record.name()] = std::move(status);
  peers_[record.name()] = std::move(peer);
  PublishClock(peers_[record.name()], core::MonotonicNow_ns());
  are_subscribers_outdated_ = true;
  next_heartbeat_ns_ = 0;  // be heard by it at once
}

// An unknown sender: the roster here is out of date.
void BusThread::RequestRoster() {
  roster_version_ = 0;
  next_hello_ns_ = std::min(next_hello_ns_, core::MonotonicNow_ns() + 20 * core::kMillisecond_ns);
}

void BusThread::UpdateSenders() {
  if (core_->session_key.empty()) return;
  if (!core_->guard->has_session_key()) {
    SessionKey key{};
    std::copy_n(core_->session_key.begin(), std::min(core_->session_key.size(), key.size()), key.begin());
    core_->guard->SetSessionKey(key, core_->instance);
  }
  KnownSenders senders;
  for (const auto& [name, peer] : peers_) {
    if (fenced_.count(peer.record.instance()) != 0) continue;
    if (!senders.push_back(core_->guard->Know(TopicId(name), peer.record.instance()))) {
      Announce("sender_limit", "no room for the key of " + name + " beside " + std::to_string(kMaxSenders) + " others");
    }
  }
  core_->guard->SetSenders(senders);
}

}  // namespace bus::detail
