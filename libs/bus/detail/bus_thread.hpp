#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "bus/detail/control.hpp"
#include "bus/detail/node_core.hpp"

namespace bus::detail {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kHeartbeatPeriod_ns = 50 * kMillisecond_ns;
constexpr std::int64_t kDeadAfter_ns = 350 * kMillisecond_ns;  // plus one heartbeat period: noticed within 0.4 s
constexpr std::int64_t kStalledAfter_ns = 400 * kMillisecond_ns;
constexpr std::int64_t kMissingAfter_ns = 1'000 * kMillisecond_ns;  // in the roster, but never heard
constexpr std::int64_t kHelloPeriod_ns = 500 * kMillisecond_ns;
constexpr std::int64_t kEagerHelloPeriod_ns = 100 * kMillisecond_ns;  // until the registry has answered
constexpr std::uint64_t kEventCredit = 1024;  // events on their way to one subscriber that it has not acknowledged

// The one thread that touches ZeroMQ sockets: registry, roster, heartbeats, STATE, EVENT and SERVICE.
//
//   peers' DEALERs --subscribe, ack, parameter request--> ROUTER (ours)
//   ROUTER --snapshot, deltas, events, parameter reply--> peers' DEALERs
//   our DEALERs, one per peer: the same in the other direction; one more DEALER to the registry
class BusThread {
 public:
  explicit BusThread(NodeCore* core) : core_(core) {}
  ~BusThread() { Stop(); }
  BusThread(const BusThread&) = delete;
  BusThread& operator=(const BusThread&) = delete;

  core::Result<void> Open();  // binds and connects
  void Start();
  void Stop();
  [[nodiscard]] bool is_running() const { return thread_.joinable(); }

 private:
  struct Peer {
    oos::NodeRecord record;
    sockaddr_in data_address{};
    sockaddr_in heartbeat_address{};
    zmq::socket_t dealer;
    bool was_heard = false;
    bool has_left = false;
    bool is_missing_told = false;
    std::int64_t since_ns = 0;  // known since
    std::int64_t last_heard_ns = 0;
    std::uint64_t wait_count = 0;  // its step thread's
    std::int64_t wait_changed_ns = 0;
    std::map<std::pair<std::uint32_t, bool>, std::size_t> topic_slots;  // id, is written -> place in its counters
    // What we read from it.
    bool is_subscribed = false;
    std::int64_t asked_ns = 0;
    std::uint64_t state_version = 0;
    std::uint64_t told_version = 0;  // by its heartbeat
    std::int64_t behind_since_ns = 0;
    std::uint64_t next_event = 0;  // 0: unknown until its ack
    std::uint64_t acked_event = 0;
  };

  // Somebody who reads from us.
  struct Subscription {
    std::string name;
    std::uint64_t instance = 0;
    bool wants_state = false;
    bool wants_events = false;
    std::uint64_t next_event = 1;
    std::uint64_t sent_event = 0;  // last that was handed to the socket; dropped ones do not count as on their way
    std::uint64_t acked_event = 0;
    bool is_out_of_credit = false;      // and it was told
    std::int64_t starved_since_ns = 0;  // an event waits for its credit; 0: none does
    [[nodiscard]] bool HasCredit() const { return sent_event < acked_event + kEventCredit; }
  };

  struct OpenCall {
    ParameterCall call;
    std::int64_t created_ns = 0;
    std::map<std::string, bool> asked;  // peer -> has answered
    bool is_accepted = false;
    ParameterAck result;  // of a call that somebody waits for
  };

  // bus_thread.cpp: registry, roster, liveness.
  void Run();
  void RunOnce();
  int PollTimeout_ms() const;
  oos::NodeRecord OwnRecord(bool with_schemas) const;
  void SendHello(bool is_goodbye);
  void ReceiveFromRegistry();
  void TakeRoster(const oos::Roster& roster);
  void AddPeer(const oos::NodeRecord& record, std::uint32_t restarts);
  void SendHeartbeats(bool is_goodbye);
  void ReceiveHeartbeats();
  void TakeHeartbeat(const oos::Heartbeat& heartbeat);
  void Lose(Peer& peer, bool has_left);
  void CheckLiveness();
  void UpdateSubscribers();
  void UpdateSenders();
  void AskForRoster();
  void Announce(const std::string& name, const std::string& detail);
  PeerStatus& StatusOf(const Peer& peer) { return core_->peers[peer.record.name()]; }

  // reliable.cpp: STATE, EVENT, SERVICE.
  bool ReadsFrom(const Peer& peer) const;
  void MaintainSubscriptions();
  void ReceiveFromPeer(Peer& peer);
  void TakeState(Peer& peer, const oos::StateEntry& entry);
  void TakeEvent(Peer& peer, const oos::EventItem& item);
  void AckEvents(Peer& peer);
  void ReceiveFromRouter();
  void TakeSubscribe(const std::string& routing, const oos::Subscribe& subscribe);
  void TakeRequest(const std::string& routing, const oos::ParameterRequest& request);
  bool SendToRouted(const std::string& routing, const oos::Control& control);
  bool SendToPeer(Peer& peer, const oos::Control& control);
  void DrainStepThread();
  void DrainEvents();
  Peer* FindReader(const Subscription& subscription);
  bool IsWaitingForCredit();
  void SendState(const StateItem& item);
  void SendEvent(const core::Event& event);
  void OpenParameterCall(const ParameterCall& call);
  void ServeCalls();
  void AnswerCall(OpenCall& open, const std::string& owner, const oos::ParameterReply& reply);
  void FlushToStepThread();

  NodeCore* core_;
  zmq::context_t context_{1};
  zmq::socket_t router_;
  zmq::socket_t registry_;
  std::string router_endpoint_;
  std::thread thread_;
  std::atomic<bool> is_stopping_{false};

  std::map<std::string, Peer> peers_;  // by name
  std::set<std::uint64_t> gone_;       // instances that said goodbye
  std::uint64_t roster_version_ = 0;
  std::int64_t next_heartbeat_ns_ = 0;
  std::int64_t next_hello_ns_ = 0;
  std::size_t next_topic_told_ = 0;
  std::size_t next_span_told_ = 0;
  bool are_subscribers_outdated_ = true;
  std::uint64_t own_state_version_ = 0;
  std::map<std::pair<std::string, std::string>, oos::StateEntry> retained_;  // topic, key
  std::map<std::string, Subscription> subscriptions_;                        // by routing id
  std::map<std::uint64_t, std::pair<std::string, std::uint64_t>> tickets_;   // -> routing id, the caller's request
  std::uint64_t next_ticket_ = 1;
  std::map<std::uint64_t, OpenCall> open_calls_;
  std::deque<core::Event> events_for_step_;
  std::deque<StateItem> states_for_step_;
  std::deque<ParameterAck> acks_for_step_;
};

}  // namespace bus::detail
