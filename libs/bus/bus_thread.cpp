#include "bus/bus_thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>

#include "bus/latest/latest_spans.hpp"
#include "bus/membership/machine_id.hpp"
#include "core/clock.hpp"

namespace bus::detail {
namespace {

constexpr std::size_t kTopicsPerHeartbeat = 30;  // in turn, as far as the bytes below allow
// A topic's counters take 60 bytes at most. A heartbeat beyond the limit would be refused, and its sender declared
// dead.
constexpr std::size_t kMaxBytesBeforeTopic = kMaxHeartbeatBytes - kEnvelopeFixedBytes - kSealBytes - 60;
constexpr int kGoodbyeLinger_ms = 100;  // for the last messages to leave; a peer that is gone delays the end by this
constexpr std::uint64_t kSettlingExchanges = 20;  // a second of heartbeats until largest_clock_bound_ns starts
// Extrapolation over it costs kMaxDrift * 20 ms = 10 us of the bound at most.
constexpr std::int64_t kClockPeriod_ns = 20 * core::kMillisecond_ns;

}  // namespace

core::Result<void> BusThread::Open() {
  machine_id_ = MachineId();
  try {
    gate_.Open(&context_, core_->keys);
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    gate_.GuardListener(&router_);
    router_.set(zmq::sockopt::router_mandatory, true);  // an unknown receiver is an error, not silence
    router_.set(zmq::sockopt::router_handover, true);
    router_.set(zmq::sockopt::linger, kGoodbyeLinger_ms);
    router_.set(zmq::sockopt::sndhwm, static_cast<int>(2 * (kEventCredit + kStateCredit)));
    router_.bind("tcp://" + core_->options.bind_address + ":*");
    router_endpoint_ = router_.get(zmq::sockopt::last_endpoint);
    ParseEndpoint(core_->data_socket.endpoint(), &own_data_address_);
    registry_ = zmq::socket_t(context_, zmq::socket_type::dealer);
    gate_.GuardWatchedConnection(&registry_, core_->keys ? core_->keys->PublicKeyOf(kRegistryKeyName) : "");
    registry_.set(zmq::sockopt::routing_id, core_->options.name + "#" + std::to_string(core_->instance));
    registry_.set(zmq::sockopt::linger, kGoodbyeLinger_ms);
    registry_.set(zmq::sockopt::immediate, true);  // no pile of old HELLOs for a registry that is not there yet
    registry_.set(zmq::sockopt::reconnect_ivl, 20);
    registry_.set(zmq::sockopt::reconnect_ivl_max, 200);
    registry_.connect(core_->options.registry);
  } catch (const zmq::error_t& error) {
    return core::Fail(core::ErrorCode::kIo, "node " + core_->options.name + ": sockets on " +
                                                core_->options.bind_address + " for registry '" +
                                                core_->options.registry + "': " + error.what() +
                                                "; the registry is given as tcp://ADDRESS:PORT");
  }
  return {};
}

void BusThread::Start() {
  // Signals are for the node's own threads.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { Run(); });
  pthread_setname_np(thread_.native_handle(), "bus-io");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void BusThread::Stop() {
  if (!thread_.joinable()) return;
  is_stopping_.store(true);
  core_->Wake();
  thread_.join();
}

int BusThread::PollTimeout_ms() const {
  std::int64_t due = std::min(next_heartbeat_ns_, next_hello_ns_);
  const bool is_waiting = !open_calls_.empty() || !events_for_step_.empty() || !states_for_step_.empty() ||
                          !acks_for_step_.empty() || core_->events_out.Front() != nullptr;
  const std::int64_t now = core::MonotonicNow_ns();
  if (is_waiting || is_connecting_) due = std::min(due, now + 5 * core::kMillisecond_ns);
  return static_cast<int>(
      std::clamp<std::int64_t>((due - now + core::kMillisecond_ns - 1) / core::kMillisecond_ns, 0, 50));
}

void BusThread::Run() {
  prctl(PR_SET_TIMERSLACK, 1UL);
  // Never real-time, whatever the thread was that started the node; but a little before other work where that is
  // allowed, so that a busy machine is not taken for a dead node.
  const sched_param normal{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), -5);
  std::vector<zmq::pollitem_t> items;
  while (!is_stopping_.load()) {
    items.clear();
    items.push_back({router_.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({registry_.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({nullptr, core_->heartbeat_socket.fd(), ZMQ_POLLIN, 0});
    items.push_back({nullptr, core_->wake_fd, ZMQ_POLLIN, 0});
    gate_.AddPollItems(&items);
    for (auto& [name, peer] : peers_) items.push_back({peer.dealer.handle(), 0, ZMQ_POLLIN, 0});
    zmq_poll(items.data(), static_cast<int>(items.size()), PollTimeout_ms());
    {
      const std::lock_guard lock(core_->mutex);
      RunOnce();
    }
    core_->changed.notify_all();
  }
  const std::lock_guard lock(core_->mutex);
  DrainStepThread();
  if (core_->options.sends_goodbye) {
    SendHeartbeats(true);
    SendHello(true);
  }
  for (auto& [name, peer] : peers_) {  // a last acknowledgement, for the writers' accounts
    if (!peer.reading.is_subscribed) continue;
    Acknowledge(peer, false);
    peer.dealer.set(zmq::sockopt::linger, kGoodbyeLinger_ms);
  }
  peers_.clear();
  router_.close();
  registry_.close();
  gate_.Close();
}

void BusThread::RunOnce() {
  std::uint64_t wakes = 0;
  [[maybe_unused]] const ssize_t got = read(core_->wake_fd, &wakes, sizeof(wakes));

  // Input first: after this thread was held up, waiting heartbeats must count before liveness is judged.
  gate_.Serve();
  core_->refused_connections.store(gate_.refused(), std::memory_order_relaxed);
  core_->registry_trouble = gate_.trouble();
  if (gate_.is_key_rejected() && !core_->is_welcomed) core_->refusal = gate_.trouble();
  ReceiveHeartbeats();
  ReceiveFromRegistry();
  for (auto& [name, peer] : peers_) ReceiveFromPeer(peer);
  ReceiveFromRouter();
  DrainStepThread();
  DrainDetours();

  const std::int64_t now = core::MonotonicNow_ns();
  if (now >= next_hello_ns_) {
    // Not connected yet: retried at once, so that a newcomer joins as soon as possible.
    const bool is_sent = SendHello(false);
    next_hello_ns_ = now + (core_->is_welcomed ? kHelloPeriod_ns : is_sent ? kEagerHelloPeriod_ns : kConnectPeriod_ns);
  }
  if (now >= next_heartbeat_ns_) {
    SendHeartbeats(false);
    next_heartbeat_ns_ = now + kHeartbeatPeriod_ns;
  }
  CheckLiveness();
  MaintainReading();
  MaintainSubscriptions();
  ServeCalls();
  if (are_subscribers_outdated_) UpdateSubscribers();
  FlushToStepThread();
}

void BusThread::SendHeartbeats(bool is_goodbye) {
  if (is_fenced_) return;
  const Counters counters = core_->CountAll();
  oos::Control control;
  oos::Heartbeat* heartbeat = control.mutable_heartbeat();
  heartbeat->set_name(core_->options.name);
  heartbeat->set_instance(core_->instance);
  heartbeat->set_wait_count(core_->wait_count.load(std::memory_order_relaxed));
  heartbeat->set_state_version(own_state_version_);
  heartbeat->set_sent(counters.sent);
  heartbeat->set_received(counters.received);
  heartbeat->set_dropped(counters.dropped);
  heartbeat->set_refused(counters.refused);
  heartbeat->set_is_goodbye(is_goodbye);
  AddCounts(heartbeat);
  AddLatestSpans(*core_, &next_span_, heartbeat);
  heartbeat->set_sent_ns(core::MonotonicNow_ns());  // reserves its bytes; the time is set below
  const std::size_t num_sent = std::min(counters.topics.size(), kTopicsPerHeartbeat);
  for (std::size_t i = 0; i < num_sent && control.ByteSizeLong() < kMaxBytesBeforeTopic; ++i) {
    const TopicCounters& topic = counters.topics[next_topic_++ % counters.topics.size()];
    oos::TopicFigures* figures = heartbeat->add_topics();
    figures->set_topic(TopicId(topic.topic));
    figures->set_is_written(topic.is_written);
    figures->set_sent(topic.sent);
    figures->set_received(topic.received);
    figures->set_dropped(topic.dropped);
    figures->set_reordered(topic.reordered);
  }
  heartbeat->set_sent_ns(core::MonotonicNow_ns());
  auto bytes = EncodeControl(core_->identity, TopicClass::kControl, control);
  core_->guard->SealControl(&bytes);
  // One stamp for all peers would be too early for the last one, whose way there would seem longer than the way back.
  // As in an answer, which is stamped before it is sealed, encoding counts as part of the way.
  const std::int64_t work_ns = core::MonotonicNow_ns() - heartbeat->sent_ns();
  for (auto& [name, peer] : peers_) {
    peer.heartbeats_sent[peer.num_heartbeats_sent++ % peer.heartbeats_sent.size()] = {
        heartbeat->sent_ns(), core::MonotonicNow_ns() - work_ns};
    core_->heartbeat_socket.Send(peer.heartbeat_address, bytes.data(), bytes.size());
  }
}

void BusThread::ReceiveHeartbeats() {
  std::array<std::uint8_t, 2048> bytes;
  for (;;) {
    const ssize_t size = recv(core_->heartbeat_socket.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size < 0) return;
    const std::int64_t received_ns = core::MonotonicNow_ns();
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    const Refusal refusal =
        core_->guard->OpenControl({bytes.data(), static_cast<std::size_t>(size)}, &envelope, &payload);
    if (refusal == Refusal::kUnknownSender) RequestRoster();
    if (refusal != Refusal::kNone) continue;
    oos::Control control;
    const bool is_read = control.ParseFromArray(payload.data(), static_cast<int>(payload.size()));
    if (is_read && control.has_clock_echo()) {
      TakeClockEcho(control.clock_echo(), received_ns);
    } else if (is_read && control.has_heartbeat()) {
      AnswerClock(control.heartbeat(), received_ns);
      TakeHeartbeat(control.heartbeat());
    } else {
      core_->guard->refusals.Add(Refusal::kBadSchema);
    }
  }
}

void BusThread::SendUnreliably(const Peer& peer, const oos::Control& control) {
  auto bytes = EncodeControl(core_->identity, TopicClass::kControl, control);
  core_->guard->SealControl(&bytes);
  core_->heartbeat_socket.Send(peer.heartbeat_address, bytes.data(), bytes.size());
}

// The four stamps of a clock comparison: a heartbeat left the peer and arrived here; the answer leaves here at once and
// arrives at the peer.
void BusThread::AnswerClock(const oos::Heartbeat& heartbeat, std::int64_t received_ns) {
  const auto found = peers_.find(heartbeat.name());
  if (found == peers_.end() || found->second.record.instance() != heartbeat.instance()) return;
  if (!IsElsewhere(found->second) || is_fenced_) return;
  oos::Control control;
  oos::ClockEcho* echo = control.mutable_clock_echo();
  echo->set_name(core_->options.name);
  echo->set_instance(core_->instance);
  echo->set_heartbeat_sent_ns(heartbeat.sent_ns());
  echo->set_received_ns(received_ns);
  echo->set_answered_ns(core::MonotonicNow_ns());
  SendUnreliably(found->second, control);
}

void BusThread::TakeClockEcho(const oos::ClockEcho& echo, std::int64_t received_ns) {
  const auto found = peers_.find(echo.name());
  const bool is_known = found != peers_.end() && found->second.record.instance() == echo.instance();
  if (!is_known || !IsElsewhere(found->second)) {
    core_->guard->refusals.Add(Refusal::kBadSchema);
    return;
  }
  for (const auto& [stamped_ns, left_ns] : found->second.heartbeats_sent) {
    if (stamped_ns != echo.heartbeat_sent_ns() || stamped_ns == 0) continue;
    if (!found->second.clock.Add({left_ns, echo.received_ns(), echo.answered_ns(), received_ns})) {
      core_->guard->refusals.Add(Refusal::kBadSchema);
    }
    return;
  }
  core_->guard->refusals.Add(Refusal::kBadSchema);  // an echo of no recent heartbeat of this node
}

// Publishes the clock estimate of a peer: in its PeerStatus, and to the readers of its LATEST topics.
void BusThread::PublishClock(Peer& peer, std::int64_t now) {
  if (now - peer.clock_published_ns < kClockPeriod_ns) return;
  peer.clock_published_ns = now;
  const ClockReading clock = IsElsewhere(peer) ? peer.clock.At(now) : ClockReading{};
  PeerStatus& status = StatusOf(peer);
  status.clock_offset_ns = clock.offset_ns;
  status.clock_bound_ns = clock.bound_ns;
  status.clock_drift_ppm = clock.drift_ppm;
  if (status.is_alive && clock.bound_ns != kUnknownBound_ns && peer.clock.num_exchanges() > kSettlingExchanges) {
    std::int64_t& largest = status.largest_clock_bound_ns;
    largest = largest == kUnknownBound_ns ? clock.bound_ns : std::max(largest, clock.bound_ns);
  }
  if (fenced_.count(peer.record.instance()) != 0) return;
  const std::int64_t offset = clock.bound_ns == kUnknownBound_ns ? kUnknownClock : clock.offset_ns;
  for (const auto& receiver : core_->receivers) {
    if (peer.topic_slots.count({receiver->id, true}) != 0) {
      receiver->clock_offset_ns.store(offset, std::memory_order_relaxed);
    }
  }
}

void BusThread::TakeHeartbeat(const oos::Heartbeat& heartbeat) {
  if (gone_.count(heartbeat.instance()) != 0) return;
  if (fenced_.count(heartbeat.instance()) != 0) {
    core_->refused_fenced.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const auto found = peers_.find(heartbeat.name());
  if (found == peers_.end() || found->second.record.instance() != heartbeat.instance()) {
    core_->guard->refusals.Add(Refusal::kUnknownSender);
    RequestRoster();
    return;
  }
  Peer& peer = found->second;
  const std::int64_t now = core::MonotonicNow_ns();
  PeerStatus& status = StatusOf(peer);
  peer.last_heard_ns = now;
  status.age_ns = now;
  TakeLatestSpans(heartbeat, core_);
  TakeCounts(peer, heartbeat);
  if (heartbeat.is_goodbye()) {
    Lose(peer, true);
    gone_.insert(heartbeat.instance());
    if (peer.record.is_observer()) {
      core_->peers.erase(heartbeat.name());
      peers_.erase(found);
    }
    return;
  }
  if (!status.is_alive && !peer.has_left) {
    status.is_alive = true;
    peer.was_heard = true;
    are_subscribers_outdated_ = true;
    if (!peer.record.is_observer()) Announce("node_found", heartbeat.name());
  }
  if (heartbeat.wait_count() != peer.wait_count || peer.wait_changed_ns == 0) {
    peer.wait_count = heartbeat.wait_count();
    peer.wait_changed_ns = now;
  }
  status.counters.sent = heartbeat.sent();
  status.counters.received = heartbeat.received();
  status.counters.dropped = heartbeat.dropped();
  status.counters.refused = heartbeat.refused();
  for (const oos::TopicFigures& figures : heartbeat.topics()) {
    const auto slot = peer.topic_slots.find({figures.topic(), figures.is_written()});
    if (slot == peer.topic_slots.end()) continue;
    TopicCounters& topic = status.counters.topics[slot->second];
    topic.sent = figures.sent();
    topic.received = figures.received();
    topic.dropped = figures.dropped();
    topic.reordered = figures.reordered();
  }
  TakeAccounts(heartbeat, &status);
}

void BusThread::Lose(Peer& peer, bool has_left) {
  PeerStatus& status = StatusOf(peer);
  const bool was_alive = status.is_alive;
  status.is_alive = false;
  status.is_stalled = false;
  peer.has_left = has_left;
  peer.reading.is_subscribed = false;
  ForgetReader(peer.record.name(), peer.record.instance());
  for (const auto& receiver : core_->receivers) {
    if (peer.topic_slots.count({receiver->id, true}) != 0) receiver->Settle();
  }
  are_subscribers_outdated_ = true;
  if (was_alive && !peer.record.is_observer()) Announce(has_left ? "node_left" : "node_lost", peer.record.name());
}

void BusThread::CheckLiveness() {
  const std::int64_t now = core::MonotonicNow_ns();
  for (auto item = peers_.begin(); item != peers_.end();) {
    Peer& peer = item->second;
    PeerStatus& status = StatusOf(peer);
    if (status.is_alive && now - peer.last_heard_ns > kDeadAfter_ns) {
      Lose(peer, false);
      if (peer.record.is_observer()) {
        core_->peers.erase(item->first);
        item = peers_.erase(item);
        continue;
      }
    }
    if (!peer.was_heard && !peer.is_missing_reported && now - peer.since_ns > kMissingAfter_ns) {
      peer.is_missing_reported = true;
      if (!peer.record.is_observer()) Announce("node_lost", peer.record.name());
    }
    PublishClock(peer, now);
    // A step thread that never called Wait() does not use the data socket at all.
    const bool is_stalled = status.is_alive && peer.wait_count > 0 && now - peer.wait_changed_ns > kStalledAfter_ns;
    if (is_stalled != status.is_stalled) {
      status.is_stalled = is_stalled;
      if (!peer.record.is_observer() && status.is_alive) {
        Announce(is_stalled ? "node_stalled" : "node_resumed", peer.record.name());
      }
    }
    ++item;
  }
}

void BusThread::Announce(const std::string& name, const std::string& detail) {
  events_for_step_.push_back({core::MonotonicNow_ns(), core_->options.name, name, detail});
}

}  // namespace bus::detail
