#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bus/accounts/account_book.hpp"
#include "bus/latest/latest_io.hpp"
#include "bus/latest/udp_socket.hpp"
#include "bus/log/tap_points.hpp"
#include "bus/node.hpp"
#include "bus/rt/spsc_ring.hpp"
#include "bus/security/keys.hpp"

namespace bus::detail {

// Data shared by the step thread and the bus thread of one node. The two exchange through rings and atomics only; the
// mutex is for the bus thread and for callers that may block (Peers, SetParameter, PollObservation).

constexpr std::uint32_t kProtocolVersion = 1;
constexpr std::size_t kMaxEventText = 255;                      // reserved in every slot of the rings of events
constexpr std::size_t kMaxStateBytes = std::size_t{64} * 1024;  // larger values delay other traffic: use BULK

struct StateItem {         // one value of a STATE topic, in either direction
  std::uint32_t slot = 0;  // of the sender or receiver
  std::string key;
  std::string bytes;
  std::uint64_t version = 0;
  bool is_reset = false;  // no value: the writer restarted, values of its earlier life are void
};

struct ParameterItem {
  std::uint64_t ticket = 0;
  core::ParameterChange change;
  std::int64_t deadline_ns = 0;  // not applied later; 0: none
};

struct ParameterAnswer {
  std::uint64_t ticket = 0;
  std::uint64_t tick = 0;
  bool is_accepted = false;
  std::string why;
  double injected_J = 0.0;
  bool is_pending = false;
};

struct ParameterCall {
  std::uint64_t request = 0;
  std::string owner;
  core::ParameterChange change;
  std::int64_t deadline_ns = 0;
  bool is_waited_for = false;  // SetParameter; otherwise PostParameter
};

struct StateSender {
  std::string topic;
  MessageType type;
  std::uint32_t slot = 0;
  struct NodeCore* core = nullptr;
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> overflows{0};  // step thread: the queue was full
  std::atomic<std::uint64_t> oversize{0};   // step thread: more than kMaxStateBytes
};

struct StateReceiver {
  StateReceiver(std::string topic_name, MessageType message_type) : topic(std::move(topic_name)), type(message_type) {}
  virtual ~StateReceiver() = default;
  virtual bool Take(const StateItem& item) = 0;
  virtual void ClearFresh() = 0;
  std::string topic;
  MessageType type;
  std::atomic<std::uint64_t> received{0};
};

struct StateAccess {
  template <class M>
  static void Accept(StateReader<M>* reader, const std::string& key, std::uint64_t version, const M& value) {
    reader->value_ = value;
    reader->values_[key] = value;
    reader->version_ = version;
    reader->is_fresh_ = true;
  }
  template <class M>
  static void Reset(StateReader<M>* reader) {
    reader->values_.clear();
  }
  template <class M>
  static void ClearFresh(StateReader<M>* reader) {
    reader->is_fresh_ = false;
  }
};

template <class M>
struct TypedStateReceiver final : StateReceiver {
  explicit TypedStateReceiver(const std::string& topic_name) : StateReceiver(topic_name, kMessageTypeOf<M>) {}
  bool Take(const StateItem& item) override {
    if (item.is_reset) {
      StateAccess::Reset(&reader);
      return true;
    }
    if (!DecodeState(item.bytes, &decoded_)) return false;
    StateAccess::Accept(&reader, item.key, item.version, decoded_);
    return true;
  }
  void ClearFresh() override { StateAccess::ClearFresh(&reader); }
  StateReader<M> reader;

 private:
  M decoded_;  // kept, and copied: a list of the same length again, as of figures, allocates nothing
};

// An observed message, not decoded yet.
struct RawObservation {
  std::string topic;
  TopicClass topic_class = TopicClass::kLatest;
  MessageType type = MessageType::kNone;
  std::string writer;
  std::uint64_t sequence = 0;
  std::int64_t publish_ns = 0;
  std::int64_t received_ns = 0;
  std::size_t num_bytes = 0;
  unsigned part = 0, num_parts = 1;
  std::string payload;
};

struct KnownTopic {
  std::string name;
  MessageType type = MessageType::kNone;
  std::string writer;
};

struct NodeCore {
  NodeCore();

  NodeOptions options;
  std::optional<Keys> keys;  // none: not encrypted
  Identity identity;
  std::uint64_t instance = 0;
  std::unique_ptr<DatagramGuard> guard;  // of both UDP sockets
  UdpSocket data_socket;                 // step thread
  UdpSocket group_socket;                // step thread; of the multicast group, where there is one
  UdpSocket heartbeat_socket;            // bus thread
  int wake_fd = -1;                      // eventfd: step thread -> bus thread
  void Wake() const noexcept;

  // Fixed after Start().
  std::vector<std::string> declaration_errors;
  std::vector<std::unique_ptr<LatestSender>> senders;
  std::vector<std::unique_ptr<LatestReceiver>> receivers;
  std::vector<std::unique_ptr<StateSender>> state_senders;
  std::vector<std::unique_ptr<StateReceiver>> state_receivers;
  std::vector<std::string> observed_patterns;
  bool reads_events = false;
  std::vector<std::string> parameter_names;  // of the parameters it owns

  TapPoints tap;  // step thread

  // Step thread -> bus thread.
  SpscRing<core::Event> events_out;
  SpscRing<StateItem> states_out;
  SpscRing<ParameterAnswer> answers_out;
  SpscRing<ParameterCall> calls_out;
  // Bus thread -> step thread.
  SpscRing<core::Event> events_in;
  SpscRing<StateItem> states_in;
  SpscRing<ParameterItem> parameters_in;
  SpscRing<ParameterAck> acks_in;

  std::atomic<std::uint64_t> wait_count{0};
  std::atomic<std::uint64_t> refused{0};  // messages of ZeroMQ
  std::atomic<std::uint64_t> refused_connections{0};
  // By its BULK socket, whose thread may outlive the node.
  std::shared_ptr<std::atomic<std::uint64_t>> refused_bulk = std::make_shared<std::atomic<std::uint64_t>>(0);
  std::atomic<std::uint64_t> refused_fenced{0};  // from a fenced instance
  std::atomic<std::uint64_t> events_sent{0};     // times subscribers
  std::atomic<std::uint64_t> events_received{0};
  std::atomic<std::uint64_t> events_dropped{0};
  std::atomic<std::uint64_t> observations_dropped{0};  // the observer was too slow
  std::atomic<std::uint64_t> next_request{1};

  // Under the mutex.
  mutable std::mutex mutex;
  std::condition_variable changed;
  bool is_welcomed = false;
  std::string refusal;                      // of the registry
  std::string registry_trouble;             // why the connection to it fails
  std::map<std::string, PeerStatus> peers;  // age_ns holds the time of the last heartbeat
  std::string session_key;                  // of UDP datagrams, from the registry; empty: they are in the clear
  AccountBook book;
  std::map<std::uint32_t, KnownTopic> known_topics;
  std::deque<ParameterCall> waiting_calls;
  std::map<std::uint64_t, ParameterAck> finished_calls;
  std::deque<RawObservation> observations;
  static constexpr std::size_t kMaxObservations = 8192;  // 2 s of 4000 messages per second; more are dropped

  [[nodiscard]] bool IsObserved(const std::string& topic) const;
  void AddObservation(RawObservation observation);  // mutex held
  [[nodiscard]] Counters CountAll() const;
};

}  // namespace bus::detail
