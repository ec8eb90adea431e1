#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bus/figures.hpp"
#include "bus/latest/latest.hpp"
#include "bus/membership/roster.hpp"
#include "bus/reliable/state.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "core/messages/logic.hpp"
#include "core/result.hpp"

namespace bus::log {
class Tap;
}

namespace bus {

// For a registry that starts after the node, on another host or by hand.
constexpr std::int64_t kDefaultStartTimeout_ns = 30'000'000'000;

struct Account;
class BulkServer;

struct NodeOptions {
  std::string name;                        // unique in the session, e.g. "haptic_node"
  std::string registry;                    // "tcp://127.0.0.1:5555"
  std::string bind_address = "127.0.0.1";  // of this node's sockets; peers must be able to reach it
  std::uint64_t session = 0;               // datagrams of another session are refused
  bool is_observer = false;                // only observes: never waited for, its end is not a fault
  bool takes_over = false;                 // fences off the holder of its name or topics, even a live one
  bool sends_goodbye = true;               // false: peers detect the end by missing heartbeats, as after kill -9
  std::string keys{};                      // key directory of the run, see bus/security/keys.hpp
  bool is_encrypted = true;                // false must be set explicitly: no keys, anybody may listen and send
  // Patterns of the LATEST topics that this node sends by ZeroMQ (TCP), for networks that block datagrams. A lost
  // packet then delays all that follow (head-of-line blocking).
  std::vector<std::string> tcp_topics{};
  // "239.255.74.50:7450": one LATEST datagram for all readers that have joined this group, on the network of the bind
  // address; unicast to the others. Empty: unicast to all.
  std::string multicast{};
  log::Tap* tap = nullptr;  // records what this node sends and receives (log/tap_recorder.hpp); outlives it
};

struct WaitResult {
  int datagrams = 0;        // read from the data socket, refused ones included
  bool is_timeout = false;  // the deadline passed
};

// A message as an observer sees it.
struct Observation {
  std::string topic;
  TopicClass topic_class = TopicClass::kLatest;
  std::string writer;
  std::uint64_t sequence = 0;
  std::int64_t publish_ns = 0;
  std::int64_t received_ns = 0;
  // On the wire, envelope included. 0: restored from the copy in a later datagram, and delivered before that one.
  std::size_t num_bytes = 0;
  MessageType type = MessageType::kNone;
  unsigned part = 0, num_parts = 1;  // of a message split over datagrams
  std::string payload;               // protobuf

  // The payload for people, one field a line.
  [[nodiscard]] std::string Text() const;
};

struct ParameterAck {
  std::uint64_t request = 0;
  std::string owner;
  bool is_accepted = false;
  std::uint64_t tick = 0;   // of the owner, at the start of which the change was applied, or began
  std::string why;          // when not accepted
  double injected_J = 0.0;  // energy injected into the scene so far
  bool is_pending = false;  // ramped or held; the owner's event parameter_settled marks its end
};

// A process's end of the bus; one per process. It owns a bus thread, which owns every reliable socket, and one UDP
// socket for LATEST topics, which belongs to the step thread.
//
// Threads: every call below belongs to the one step thread, except those marked "any thread". LatestWriter::Send,
// Wait, Emit, PollEvent, PollParameter, AckParameter and PostParameter neither lock nor, once warm, allocate.
class Node {
 public:
  // Opens the sockets; nothing is sent yet. Call it before the thread becomes real-time (SetUpThread): ZeroMQ's own
  // thread inherits the scheduling of its creator.
  static core::Result<std::unique_ptr<Node>> Create(const NodeOptions& options);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // --- Before Start(): the topics that are written and read. A topic outside the table (topics.hpp) or with another
  // message type makes Start() fail. References stay valid as long as the node.
  template <class M>
  LatestWriter<M> WriteLatest(const std::string& topic);
  template <class M>
  LatestReader<M>& ReadLatest(const std::string& topic);
  template <class M>
  StateWriter<M> WriteState(const std::string& topic);
  template <class M>
  StateReader<M>& ReadState(const std::string& topic);
  void ReadEvents();  // events of other nodes; this node's own (node_lost, ...) come without it
  void OwnParameters(std::vector<std::string> names);  // for PollParameter(); other names are refused
  void Observe(const std::string& pattern);  // all messages whose topic matches, see PollObservation(); not real-time

  // Starts the bus thread and waits until the registry has answered, so nodes may start in any order. Timeout 0: does
  // not wait. Errors: kInvalidInput when a declaration is wrong, or the registry refuses (duplicate name, second
  // writer, incompatible schema: the text names both nodes); kTimeout.
  core::Result<void> Start(std::int64_t timeout_ns = kDefaultStartTimeout_ns);

  // Blocks until all named peers are alive, or fails with the names that are missing. Not real-time; any thread.
  core::Result<void> WaitForPeers(const std::vector<std::string>& names, std::int64_t timeout_ns);

  // Blocks until at least one datagram has arrived or the deadline (CLOCK_MONOTONIC) has passed, then decodes all that
  // wait into their readers. A deadline in the past only decodes what is there. First clears is_fresh() of all readers,
  // which then marks those that this call updated.
  WaitResult Wait(std::int64_t deadline_ns);
  WaitResult Poll() { return Wait(0); }

  // --- EVENT. False: not taken, counted as dropped (queue full). Texts are cut at 255 bytes each.
  bool Emit(const core::Event& event);
  bool PollEvent(core::Event* event);  // others' events, and node_lost, node_found, node_left (detail: the peer's name)

  // --- SERVICE, parameters. Owner: take the change (of a name given to OwnParameters), apply it at the start of a
  // tick, and acknowledge with that tick.
  bool PollParameter(core::ParameterChange* change, std::uint64_t* ticket);
  void AckParameter(std::uint64_t ticket, std::uint64_t tick, bool is_accepted, const std::string& why = {},
                    double injected_J = 0.0, bool is_pending = false);
  // Caller, without waiting: returns a request number for PollAck (0: queue full). `owner` "" means every node that
  // owns parameters; each of them answers.
  std::uint64_t PostParameter(const std::string& owner, const core::ParameterChange& change,
                              std::int64_t timeout_ns = core::kNanosecondsPerSecond);
  bool PollAck(ParameterAck* ack);  // including refusals and timeouts, by the owner's name
  // Caller, waiting: the acknowledgement of the owner that accepted it. With `owner` "", one acceptance is enough. Not
  // real-time; any thread, but not mixed with PollAck.
  core::Result<ParameterAck> SetParameter(const std::string& owner, const core::ParameterChange& change,
                                          std::int64_t timeout_ns = core::kNanosecondsPerSecond);

  // --- Observing. Not real-time.
  bool PollObservation(Observation* observation);
  std::vector<PeerStatus> Peers() const;        // any thread
  bool IsAlive(const std::string& peer) const;  // any thread
  Counters counters() const;                    // of this node; any thread
  std::vector<Account> Accounts() const;        // of this node with each peer, by topic (ledger.hpp); any thread

  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] std::uint64_t session() const;
  [[nodiscard]] std::uint64_t instance() const;  // differs after a restart

 private:
  friend class BulkServer;  // adds its refusals to the node's counters
  struct Impl;
  explicit Node(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus
