#include "bus/security/gate.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace bus::detail {
namespace {

constexpr const char* kAllowListEndpoint = "inproc://zeromq.zap.01";
constexpr const char* kDomain = "bus";
constexpr std::size_t kQuestionFrames = 7;  // version, request, domain, address, identity, mechanism, key

// All frames of one message; empty: none has arrived.
std::vector<zmq::message_t> ReceiveAll(zmq::socket_t* socket) {
  std::vector<zmq::message_t> frames;
  do {
    zmq::message_t frame;
    if (!socket->recv(frame, zmq::recv_flags::dontwait)) break;
    frames.push_back(std::move(frame));
  } while (frames.back().more());
  return frames;
}

bool IsConnection(int fd) {
  int type = 0;
  socklen_t size = sizeof(type);
  sockaddr_storage peer;
  socklen_t peer_size = sizeof(peer);
  return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_STREAM &&
         getpeername(fd, reinterpret_cast<sockaddr*>(&peer), &peer_size) == 0 && peer.ss_family == AF_INET;
}

}  // namespace

void Gate::Open(zmq::context_t* context, const std::optional<Keys>& keys) {
  context_ = context;
  keys_ = &keys;
  if (!has_keys()) return;
  allow_list_ = zmq::socket_t(*context, zmq::socket_type::rep);
  allow_list_.set(zmq::sockopt::linger, 0);
  allow_list_.bind(kAllowListEndpoint);
}

void Gate::GuardListener(zmq::socket_t* socket) {
  socket->set(zmq::sockopt::handshake_ivl, kHandshakeLimit_ms);
  socket->set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  if (has_keys()) {
    socket->set(zmq::sockopt::curve_server, true);
    socket->set(zmq::sockopt::curve_secretkey, (*keys_)->own.secret_key);
    socket->set(zmq::sockopt::zap_domain, kDomain);
  }
  Listener& listener = listeners_.emplace_back();
  listener.monitor = Watch(socket, ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                                       ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                                       ZMQ_EVENT_HANDSHAKE_FAILED_AUTH);
}

void GuardConnection(zmq::socket_t* socket, const std::optional<Keys>& keys, const std::string& server_key) {
  socket->set(zmq::sockopt::handshake_ivl, kHandshakeLimit_ms);
  socket->set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  if (!keys) return;
  socket->set(zmq::sockopt::curve_serverkey, server_key);
  socket->set(zmq::sockopt::curve_publickey, keys->own.public_key);
  socket->set(zmq::sockopt::curve_secretkey, keys->own.secret_key);
}

void Gate::GuardConnection(zmq::socket_t* socket, const std::string& server_key) const {
  detail::GuardConnection(socket, *keys_, server_key);
}

void Gate::GuardWatchedConnection(zmq::socket_t* socket, const std::string& server_key) {
  GuardConnection(socket, server_key);
  watched_ = Watch(socket, ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                               ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH);
}

zmq::socket_t Gate::Watch(zmq::socket_t* socket, int events) {
  const std::string endpoint = "inproc://watch-" + std::to_string(++num_watched_);
  if (zmq_socket_monitor(socket->handle(), endpoint.c_str(), events) != 0) throw zmq::error_t();
  zmq::socket_t monitor(*context_, zmq::socket_type::pair);
  monitor.set(zmq::sockopt::linger, 0);
  monitor.set(zmq::sockopt::rcvhwm, 0);  // unlimited: a lost event would falsify the count
  monitor.connect(endpoint);
  return monitor;
}

void Gate::AddPollItems(std::vector<zmq::pollitem_t>* items) {
  if (allow_list_) items->push_back({allow_list_.handle(), 0, ZMQ_POLLIN, 0});
  if (watched_) items->push_back({watched_.handle(), 0, ZMQ_POLLIN, 0});
  for (Listener& listener : listeners_) items->push_back({listener.monitor.handle(), 0, ZMQ_POLLIN, 0});
}

void Gate::Serve() {
  if (allow_list_) ServeAllowList();
  if (watched_) ServeWatched();
  for (Listener& listener : listeners_) ServeListener(&listener);
}

void Gate::Close() {
  listeners_.clear();
  if (watched_) watched_.close();
  if (allow_list_) allow_list_.close();
}

std::string Gate::KeyNameOf(zmq::message_t& message) {
  const char* name = zmq_msg_gets(message.handle(), "User-Id");  // null: no such property
  return name == nullptr ? std::string() : std::string(name);
}

// libzmq sends each proven key as a ZAP request; the answer admits or refuses it, and carries the name of the key.
void Gate::ServeAllowList() {
  for (;;) {
    const std::vector<zmq::message_t> question = ReceiveAll(&allow_list_);
    if (question.empty()) return;
    std::string status = "400", name;
    if (question.size() == kQuestionFrames && question[5].to_string_view() == "CURVE" && question[6].size() == 32) {
      std::array<char, 41> text;
      zmq_z85_encode(text.data(), static_cast<const std::uint8_t*>(question[6].data()), 32);
      const auto found = (*keys_)->allowed.find(text.data());
      if (found != (*keys_)->allowed.end()) {
        status = "200";
        name = found->second;
      }
    }
    const std::string request = question.size() > 1 ? question[1].to_string() : std::string();
    const std::array<std::string, 6> answer = {"1.0", request, status, "", name, ""};
    for (std::size_t i = 0; i < answer.size(); ++i) {
      allow_list_.send(zmq::buffer(answer[i]),
                       i + 1 < answer.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
  }
}

void Gate::ServeListener(Listener* listener) {
  for (;;) {
    const std::vector<zmq::message_t> frames = ReceiveAll(&listener->monitor);
    if (frames.empty()) return;
    // Frame 1: u16 event, u32 value (the file descriptor, where there is one).
    std::uint16_t event = 0;
    std::int32_t value = 0;
    if (frames[0].size() != sizeof(event) + sizeof(value)) continue;
    std::memcpy(&event, frames[0].data(), sizeof(event));
    std::memcpy(&value, static_cast<const char*>(frames[0].data()) + sizeof(event), sizeof(value));
    TakeEvent(listener, event, value);
  }
}

void Gate::TakeEvent(Listener* listener, std::uint16_t event, int fd) {
  std::vector<int>& in_handshake = listener->in_handshake;
  switch (event) {
    case ZMQ_EVENT_ACCEPTED:
      in_handshake.push_back(fd);
      listener->open.insert(fd);
      // libzmq has no such limit. It owns the socket and may have closed it by now; then the number may belong to
      // another connection, but hardly to one of fewer.
      if (listener->open.size() > kMaxConnections && IsConnection(fd)) shutdown(fd, SHUT_RDWR);
      break;
    case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
      if (!in_handshake.empty()) in_handshake.erase(in_handshake.begin());
      break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      listener->has_failed = true;
      break;
    case ZMQ_EVENT_DISCONNECTED: {
      listener->open.erase(fd);
      const auto found = std::find(in_handshake.begin(), in_handshake.end(), fd);
      if (found != in_handshake.end()) {
        in_handshake.erase(found);
        CountRefused();
      } else if (listener->has_failed) {  // its handshake was assumed to have succeeded
        if (!in_handshake.empty()) in_handshake.erase(in_handshake.begin());
        CountRefused();
      }
      listener->has_failed = false;
      break;
    }
    default:
      break;
  }
}

void Gate::ServeWatched() {
  for (;;) {
    const std::vector<zmq::message_t> frames = ReceiveAll(&watched_);
    if (frames.empty()) return;
    std::uint16_t event = 0;
    std::memcpy(&event, frames[0].data(), std::min(sizeof(event), frames[0].size()));
    if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
      trouble_.clear();
    } else if (event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
      trouble_ = "it does not know the key of " + (*keys_)->own_name + "; is this the key directory of that run?";
      is_key_rejected_ = true;
    } else if (event == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL) {
      trouble_ = has_keys() ? "it does not encrypt, or is no registry" : "it wants encryption and a key";
    } else if (trouble_.empty()) {
      trouble_ = has_keys() ? "the handshake fails; is this the key directory of that run?"
                            : "the handshake fails; it may want encryption and a key";
    }
  }
}

}  // namespace bus::detail
