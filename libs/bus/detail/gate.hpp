#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "bus/keys.hpp"

namespace bus::detail {

// What a listening socket is protected by.
constexpr int kHandshakeLimit_ms = 3'000;    // a connection that has not proven its key by then is closed
constexpr std::size_t kMaxConnections = 64;  // of one listener, those in their handshake included
constexpr std::int64_t kMaxFrameBytes = std::int64_t{16} << 20;  // the connection of a larger one is closed

// Limits of a socket that connects, and CURVE where there are keys. Before connect; throws zmq::error_t. Who connects
// lets nobody in, so that is all it needs.
void GuardConnection(zmq::socket_t* socket, const std::optional<Keys>& keys, const std::string& server_key);

// Guards the ZeroMQ sockets of one context: CURVE on every link, the allow-list (a ZAP handler [ZeroMQ RFC 27], without
// which libzmq lets every key in), the limits above, and the count of connections that were refused. All calls from the
// thread that owns the sockets; refused() from any. Without keys only the limits are set.
class Gate {
 public:
  // First of all. `keys` outlives the gate. Throws zmq::error_t, as the next three do.
  void Open(zmq::context_t* context, const std::optional<Keys>& keys);
  void GuardListener(zmq::socket_t* socket);                                         // before bind
  void GuardConnection(zmq::socket_t* socket, const std::string& server_key) const;  // before connect
  // As GuardConnection; trouble() then tells why it does not come about.
  void GuardWatchedConnection(zmq::socket_t* socket, const std::string& server_key);

  void AddPollItems(std::vector<zmq::pollitem_t>* items);
  void Serve();  // does what waits, without waiting
  void Close();  // after the guarded sockets

  // Connections that were closed before they had proven their key, or over the limit.
  [[nodiscard]] std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] bool is_key_rejected() const { return is_key_rejected_; }
  // Name of the key that the message's sender has proven; empty: not encrypted.
  [[nodiscard]] static std::string KeyNameOf(zmq::message_t& message);

 private:
  // Connections of one listener. A handshake's success does not tell which connection it was, so the oldest is taken,
  // and a failure told afterwards of a connection that was taken for a good one puts that right: the count is exact as
  // soon as as many have ended as have failed.
  struct Listener {
    zmq::socket_t monitor;
    std::vector<int> in_handshake;  // sockets, oldest first
    std::set<int> open;
    bool has_failed = false;  // the next that ends has failed
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
  zmq::socket_t allow_list_;  // answers libzmq's questions
  std::vector<Listener> listeners_;
  zmq::socket_t watched_;
  std::string trouble_;
  bool is_key_rejected_ = false;
  int num_watched_ = 0;
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace bus::detail
