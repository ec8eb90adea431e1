#pragma once

#include <array>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "bus/membership/clock_estimate.hpp"
#include "bus/node_core.hpp"
#include "bus/reliable/reliable.hpp"
#include "bus/security/gate.hpp"
#include "bus/wire/control.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus::detail {

// A peer is dead after seven missed heartbeats. Shorter would take a busy machine for a dead node; longer would break
// the limit of 0.4 s for node_lost.
constexpr std::int64_t kHeartbeatPeriod_ns = 50 * core::kMillisecond_ns;
constexpr std::int64_t kDeadAfter_ns = 350 * core::kMillisecond_ns;  // reported within one heartbeat period more: 0.4 s
constexpr std::int64_t kStalledAfter_ns = 400 * core::kMillisecond_ns;    // no Node::Wait: as long as until node_lost
constexpr std::int64_t kMissingAfter_ns = 1'000 * core::kMillisecond_ns;  // in the roster, but no heartbeat yet
constexpr std::int64_t kHelloPeriod_ns = 500 * core::kMillisecond_ns;     // a new registry knows all nodes after that
constexpr std::int64_t kConnectPeriod_ns = 5 * core::kMillisecond_ns;     // retry while a ZeroMQ handshake is under way
constexpr std::int64_t kEagerHelloPeriod_ns = 100 * core::kMillisecond_ns;  // until the registry has answered

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
    bool is_missing_reported = false;
    std::int64_t since_ns = 0;  // known since
    std::int64_t last_heard_ns = 0;
    std::uint64_t wait_count = 0;  // its step thread's
    std::int64_t wait_changed_ns = 0;
    // This node's newest event when it learned of the peer, or lost it: later events are for the peer.
    std::uint64_t events_before = 0;
    std::map<std::pair<std::uint32_t, bool>, std::size_t> topic_slots;  // id, is written -> place in its counters
    PeerReading reading;
    ClockEstimate clock;  // of another machine
    std::int64_t clock_published_ns = 0;
    // The newest heartbeats to it: their stamp, which its echo names, and when each left for this peer.
    std::array<std::pair<std::int64_t, std::int64_t>, 16> heartbeats_sent{};
    std::size_t num_heartbeats_sent = 0;
  };

  struct OwnerRequest {
    std::uint64_t instance = 0;
    std::int64_t sent_ns = 0;
    bool has_answered = false;
  };
  struct OpenCall {
    ParameterCall call;
    std::int64_t created_ns = 0;
    std::map<std::string, OwnerRequest> requests;  // by the peer's name
    ParameterAck result;                           // of a SetParameter call
  };

  // A request that this node received; kept to answer its repetitions.
  struct Served {
    std::string routing;
    bool is_answered = false;
    oos::ParameterReply reply;
  };
  using RequestKey = std::pair<std::uint64_t, std::uint64_t>;  // the caller's instance, its number

  // membership.cpp: registry, roster.
  oos::NodeRecord OwnRecord(bool with_schemas) const;
  bool SendHello(bool is_goodbye);
  bool IsAdmitted(const std::string& routing, zmq::message_t& message) const;
  void ReceiveFromRegistry();
  void TakeRoster(const oos::Roster& roster);
  void AddPeer(const oos::NodeRecord& record, std::uint32_t restarts);
  void FenceOff(std::uint64_t instance);
  void TakeFence(const std::string& why);
  void RequestRoster();
  void UpdateSenders();

  // bus_thread.cpp: heartbeats, clocks, liveness.
  void Run();
  void RunOnce();
  int PollTimeout_ms() const;
  void SendHeartbeats(bool is_goodbye);
  void ReceiveHeartbeats();
  void TakeHeartbeat(const oos::Heartbeat& heartbeat);
  bool IsElsewhere(const Peer& peer) const { return peer.record.machine_id() != machine_id_; }
  void SendUnreliably(const Peer& peer, const oos::Control& control);
  void AnswerClock(const oos::Heartbeat& heartbeat, std::int64_t received_ns);
  void TakeClockEcho(const oos::ClockEcho& echo, std::int64_t received_ns);
  void PublishClock(Peer& peer, std::int64_t now);
  void Lose(Peer& peer, bool has_left);
  void CheckLiveness();
  void Announce(const std::string& name, const std::string& detail);
  PeerStatus& StatusOf(const Peer& peer) { return core_->peers[peer.record.name()]; }

  // latest_ways.cpp: readers of LATEST, and the detour by ZeroMQ.
  void UpdateSubscribers();
  void DrainDetours();
  bool TakeDetoured(std::span<const std::uint8_t> bytes);

  // reliable_reader.cpp: the reading end of STATE and EVENT.
  bool ReadsFrom(const Peer& peer) const;
  void MaintainReading();
  void Subscribe(Peer& peer, bool wants_state, bool wants_events);
  void AddReadings(const Peer& peer, google::protobuf::RepeatedPtrField<oos::Reading>* readings);
  void RequestMissing(Peer& peer);
  void ReceiveFromPeer(Peer& peer);
  void TakeSubscribeAck(Peer& peer, const oos::SubscribeAck& ack);
  void TakeSnapshot(Peer& peer, const oos::StateSnapshot& snapshot);
  void TakeDelta(Peer& peer, const oos::StateEntry& entry);
  void TakeState(Peer& peer, const oos::StateEntry& entry);
  void PushState(StateItem item);
  void TakeEvent(Peer& peer, const oos::EventItem& item);
  void TakeCounts(Peer& peer, const oos::Heartbeat& heartbeat);
  void TakeAccounts(const oos::Heartbeat& heartbeat, PeerStatus* status) const;
  void Acknowledge(Peer& peer, bool resend);
  Account* EventsOf(const Peer& peer);
  std::uint64_t EventPlace(const Peer& peer);
  bool SendToPeer(Peer& peer, const oos::Control& control);

  // reliable_writer.cpp: the writing end of STATE and EVENT.
  void ReceiveFromRouter();
  void TakeSubscribe(const std::string& routing, const oos::Subscribe& subscribe);
  void TakeReading(const oos::Reading& reading, std::uint64_t instance);
  void RewindEvents(Subscription& subscription, std::uint64_t place);
  bool AckSubscription(const std::string& routing, const Subscription& subscription);
  void RequestAcknowledgement(const std::string& routing, Subscription* subscription, std::int64_t now_ns);
  void SendSnapshot(const std::string& routing, Subscription& subscription);
  void TakeEventAck(const std::string& routing, const oos::EventAck& ack);
  void Evict(const std::string& routing, Subscription& subscription, const std::string& why);
  void MaintainSubscriptions();
  void ForgetReader(const std::string& name, std::uint64_t instance);
  void AddCounts(oos::Heartbeat* heartbeat);
  bool SendToRouted(const std::string& routing, const oos::Control& control);
  bool SendBytesToRouted(const std::string& routing, std::span<const std::uint8_t> bytes);
  void DrainStepThread();
  void DrainEvents();
  Peer* FindReader(const Subscription& subscription);
  bool IsHeldUpByReaders();
  void SendState(const StateItem& item);
  void AppendEvent(const core::Event& event);
  void PumpEvents(const std::string& routing, Subscription& subscription);
  void FlushToStepThread();

  // service.cpp: parameter calls, both ends.
  void TakeRequest(const std::string& routing, const oos::ParameterRequest& request);
  std::string FindFault(const oos::ParameterRequest& request) const;
  void SendReply(Served& served);
  void SendReplies();
  void OpenParameterCall(const ParameterCall& call);
  void ServeCalls();
  void CallOwners(OpenCall& open);
  bool SendRequest(const ParameterCall& call, Peer& owner);
  void TakeReply(const Peer& peer, const oos::ParameterReply& reply);
  void AnswerCall(OpenCall& open, const std::string& owner, const oos::ParameterReply& reply);

  NodeCore* core_;
  zmq::context_t context_{1};
  Gate gate_;  // closed before context_
  zmq::socket_t router_;
  zmq::socket_t registry_;
  std::string router_endpoint_;
  sockaddr_in own_data_address_{};
  std::thread thread_;
  std::atomic<bool> is_stopping_{false};

  std::map<std::string, Peer> peers_;  // by name
  std::set<std::uint64_t> gone_;       // instances that said goodbye
  std::set<std::uint64_t> fenced_;     // instances that another has replaced
  bool is_fenced_ = false;             // this one
  std::string machine_id_;
  std::uint64_t roster_version_ = 0;
  std::int64_t next_heartbeat_ns_ = 0;
  std::int64_t next_hello_ns_ = 0;
  std::size_t next_topic_ = 0;
  std::size_t next_span_ = 0;
  std::size_t next_account_ = 0;
  bool are_subscribers_outdated_ = true;
  bool is_connecting_ = false;  // a SUBSCRIBE waits for its connection
  EventLog event_log_;
  std::uint64_t own_state_version_ = 0;
  std::map<std::uint32_t, std::uint64_t> own_counts_;                        // changes of each STATE topic
  std::map<std::pair<std::string, std::string>, oos::StateEntry> retained_;  // topic, key
  std::map<std::string, Subscription> subscriptions_;                        // by routing id
  std::map<RequestKey, Served> served_;
  std::deque<RequestKey> served_order_;  // oldest first
  std::map<std::uint64_t, RequestKey> tickets_;
  std::uint64_t next_ticket_ = 1;
  std::map<std::uint64_t, OpenCall> open_calls_;
  std::deque<core::Event> events_for_step_;
  std::deque<StateItem> states_for_step_;
  std::deque<ParameterAck> acks_for_step_;
};

}  // namespace bus::detail
