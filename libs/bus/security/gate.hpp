#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "bus/security/keys.hpp"

namespace bus::detail {

// Limits that protect a listening socket.
constexpr int kHandshakeLimit_ms = 3'000;  // to prove a key: two round trips, and a TCP retransmission (1 s)
// Of one listener, handshakes included. A run needs one for each of its five nodes and each tool.
constexpr std::size_t kMaxConnections = 64;
// Twice kMaxMessageBytes; a larger frame closes its connection.
constexpr std::int64_t kMaxFrameBytes = std::int64_t{16} << 20;

// Sets limits, and CURVE where there are keys, on a socket that connects. Before connect; throws zmq::error_t. A
// connecting socket accepts nobody, so it needs no allow-list.
void GuardConnection(zmq::socket_t* socket, const std::optional<Keys>& keys, const std::string& server_key);

// Guards the ZeroMQ sockets of one context: CURVE on every link, the allow-list (a ZAP handler [ZeroMQ RFC 27]; without
// one libzmq accepts every key), the limits above, and a count of refused connections. All calls from the thread that
// owns the sockets; refused() from any. Without keys only the limits apply.
class Gate {
 public:
  // Before every other call. `keys` outlives the gate. Throws zmq::error_t, as the next three do.
  void Open(zmq::context_t* context, const std::optional<Keys>& keys);
  void GuardListener(zmq::socket_t* socket);                                         // before bind
  void GuardConnection(zmq::socket_t* socket, const std::string& server_key) const;  // before connect
  // As GuardConnection; if it fails, trouble() gives the reason.
  void GuardWatchedConnection(zmq::socket_t* socket, const std::string& server_key);

  void AddPollItems(std::vector<zmq::pollitem_t>* items);
  void Serve();  // handles what has arrived; does not block
  void Close();  // after the guarded sockets

  // Connections that were closed before they had proven their key, or over the limit.
  [[nodiscard]] std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] bool is_key_rejected() const { return is_key_rejected_; }
  // Name of the key that the message's sender has proven; empty: not encrypted.
  [[nodiscard]] static std::string KeyNameOf(zmq::message_t& message);

 private:
  // Connections of one listener. libzmq reports a successful handshake without its socket, so the oldest connection is
  // assumed; a later failure of that connection corrects the assumption. The count of refusals is exact once every
  // failed connection has ended.
  struct Listener {
    zmq::socket_t monitor;
    std::vector<int> in_handshake;  // sockets, oldest first
    std::set<int> open;
    bool has_failed = false;  // the next one that ends counts as failed
  };

  zmq::socket_t Watch(zmq::socket_t* socket, int events);
  void ServeAllowList();
  void ServeListener(Listener* listener);
  void TakeEvent(Listener* listener, std::uint16_t event, int fd);
  void ServeWatched();
  [[nodiscard]] bool has_keys() const { return keys_->has_value(); }
  void CountRefused() { refused_.fetch_add(1, std::memory_order_relaxed); }

  zmq::context_t* context_ = nullptr;
  const std::optional<Keys>* keys_ = nullptr;
  zmq::socket_t allow_list_;  // answers libzmq's ZAP requests
  std::vector<Listener> listeners_;
  zmq::socket_t watched_;
  std::string trouble_;
  bool is_key_rejected_ = false;
  int num_watched_ = 0;
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace bus::detail
