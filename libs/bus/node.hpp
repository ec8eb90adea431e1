#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bus/figures.hpp"
#include "bus/latest.hpp"
#include "bus/roster.hpp"
#include "bus/state.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "core/messages/logic.hpp"
#include "core/result.hpp"

namespace bus::log {
class Tap;
}

namespace bus {

constexpr std::int64_t kDefaultStartTimeout_ns = 30'000'000'000;

struct Account;
class BulkServer;

struct NodeOptions {
  std::string name;                        // unique in the session, e.g. "haptic_node"
  std::string registry;                    // "tcp://127.0.0.1:5555"
  std::string bind_address = "127.0.0.1";  // of this node's sockets; peers must be able to reach it
  std::uint64_t session = 0;               // datagrams of another session are refused
  bool is_observer = false;                // looks on: never waited for, its end is not a fault
  bool takes_over = false;                 // from whoever has its name or writes its topics, also a living one
  bool says_goodbye = true;                // false: peers find out by silence, as after kill -9
  std::string keys;                        // key directory of the run, see bus/keys.hpp
  bool is_encrypted = true;                // false, said explicitly: no keys, anybody may listen in and speak
  // Patterns of the LATEST topics that this node sends by ZeroMQ, where the network does not let their datagrams
  // through. Then a lost packet holds up all that follow, and what is late stays in the way.
  std::vector<std::string> tcp_topics;
  // "239.255.74.50:7450": LATEST goes once to all who have joined that group, on the network of the bind address, and
  // by unicast to the others. Empty: by unicast to all.
  std::string multicast;
  log::Tap* tap = nullptr;  // gets what this node sends and takes (log/tap_recorder.hpp); outlives it
};

struct WaitResult {
  int datagrams = 0;        // data datagrams taken off the socket, refused ones included
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
  // On the wire, envelope included. 0: the message's own datagram has not come, this is the copy that travelled with a
  // later one, before which it is told.
  std::size_t num_bytes = 0;
  MessageType type = MessageType::kNone;
  unsigned part = 0, num_parts = 1;  // of a message that was split
  std::string payload;               // protobuf

  // The payload for people, one field a line.
  [[nodiscard]] std::string Text() const;
};

struct ParameterAck {
  std::uint64_t request = 0;
  std::string owner;
  bool is_accepted = false;
  std::uint64_t tick = 0;   // of the owner, at whose top the change was applied, or began
  std::string why;          // when not accepted
  double injected_J = 0.0;  // energy that it gave the scene by now
  bool is_pending = false;  // ramped or held; the owner's event parameter_settled tells its end
};

// A process's end of the bus; one per process. It owns a bus thread, which owns every reliable socket, and one UDP
// socket for LATEST topics, which belongs to the step thread.
//
// Threads: everything below is for the one step thread, except where it says "any thread". LatestWriter::Send,
// Wait, Emit, PollEvent, PollParameter, AckParameter and PostParameter neither lock nor, once warm, allocate.
class Node {
 public:
  // Opens the sockets; nothing is sent yet. Call it before the thread becomes real-time (SetUpThread): ZeroMQ's own
  // thread is scheduled as the one that creates it.
  static core::Result<std::unique_ptr<Node>> Create(const NodeOptions& options);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // --- Before Start(): what is written and read. A topic outside the table (topics.hpp) or with another message type
  // is reported by Start(). References stay valid as long as the node.
  template <class M>
  LatestWriter<M> WriteLatest(const std::string& topic);
  template <class M>
  LatestReader<M>& ReadLatest(const std::string& topic);
  template <class M>
  StateWriter<M> WriteState(const std::string& topic);
  template <class M>
  StateReader<M>& ReadState(const std::string& topic);
  void ReadEvents();  // events of other nodes; the node's own findings (node_lost, ...) come without it
  void OwnParameters(std::vector<std::string> names);  // this node answers PollParameter(); others are refused for it
  void Observe(const std::string& pattern);  // everything whose topic matches, see PollObservation(); not real-time

  // Starts the bus thread and waits until the registry has answered, so nodes may start in any order. Timeout 0: does
  // not wait. Fails when a declaration is wrong, or the registry refuses (name twice, topic written twice, schema
  // broken: the text says who and what), or does not answer in time.
  core::Result<void> Start(std::int64_t timeout_ns = kDefaultStartTimeout_ns);

  // Blocks until all named peers are alive, or fails with the names that are missing. Not real-time; any thread.
  core::Result<void> WaitForPeers(const std::vector<std::string>& names, std::int64_t timeout_ns);

  // Blocks until at least one datagram has arrived or the deadline (CLOCK_MONOTONIC) has passed, then decodes all that
  // wait into their readers. A deadline in the past only decodes what is there. Before: is_fresh() of all readers is
  // cleared, so it tells what this call brought.
  WaitResult Wait(std::int64_t deadline_ns);
  WaitResult Poll() { return Wait(0); }

  // --- EVENT. False: not taken, counted as dropped (queue full). Texts are cut at 255 bytes each.
  bool Emit(const core::Event& event);
  bool PollEvent(core::Event* event);  // others' events, and node_lost, node_found, node_left (detail: the peer's name)

  // --- SERVICE, parameters. Owner: take the change (one of the names given), apply it at the top of the tick,
  // acknowledge with that tick.
  bool PollParameter(core::ParameterChange* change, std::uint64_t* ticket);
  void AckParameter(std::uint64_t ticket, std::uint64_t tick, bool is_accepted, const std::string& why = {},
                    double injected_J = 0.0, bool is_pending = false);
  // Caller, without waiting: returns a request number for PollAck (0: queue full). `owner` "" means every node that
  // owns parameters; each of them answers.
  std::uint64_t PostParameter(const std::string& owner, const core::ParameterChange& change,
                              std::int64_t timeout_ns = core::kNanosecondsPerSecond);
  bool PollAck(ParameterAck* ack);  // also a refusal or a timeout, by name
  // Caller, waiting: what the owner that accepted it said. With `owner` "", one owner that accepts is enough. Not
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
  friend class BulkServer;  // counts what it refuses on the node's books
  struct Impl;
  explicit Node(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus
