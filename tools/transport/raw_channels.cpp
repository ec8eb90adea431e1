#include "tools/transport/raw_channels.hpp"

#include <linux/futex.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstring>
#include <ctime>
#include <zmq.hpp>

#include "bus/latest/udp_socket.hpp"

namespace transport {
namespace {

using Bytes = std::vector<std::uint8_t>;

class UdpChannel final : public Channel {
 public:
  UdpChannel(std::size_t num_bytes, bus::detail::UdpSocket near, bus::detail::UdpSocket far)
      : Channel("raw UDP", num_bytes), near_(std::move(near)), far_(std::move(far)), out_(num_bytes), in_(num_bytes) {
    bus::detail::ParseEndpoint(far_.endpoint(), &address_);
  }
  bool Send(std::int64_t now_ns) override {
    std::memcpy(out_.data(), &now_ns, sizeof(now_ns));
    return near_.Send(address_, out_.data(), out_.size());
  }
  std::int64_t Receive() override {
    pollfd item{far_.fd(), POLLIN, 0};
    poll(&item, 1, kPatience_ms);
    std::int64_t sent_ns = 0;
    if (recv(far_.fd(), in_.data(), in_.size(), MSG_DONTWAIT) > 0) std::memcpy(&sent_ns, in_.data(), sizeof(sent_ns));
    return sent_ns;
  }

 private:
  bus::detail::UdpSocket near_, far_;
  sockaddr_in address_{};
  Bytes out_, in_;
};

class ZeroMqChannel final : public Channel {
 public:
  ZeroMqChannel(const std::string& name, const std::string& endpoint, std::size_t num_bytes)
      : Channel(name, num_bytes) {
    pull_.set(zmq::sockopt::rcvtimeo, kPatience_ms);
    push_.set(zmq::sockopt::linger, 0);
    pull_.bind(endpoint);
    push_.connect(pull_.get(zmq::sockopt::last_endpoint));
  }
  bool Send(std::int64_t now_ns) override {
    zmq::message_t message(num_bytes());
    std::memcpy(message.data(), &now_ns, sizeof(now_ns));
    return push_.send(message, zmq::send_flags::dontwait).has_value();
  }
  std::int64_t Receive() override {
    zmq::message_t message;
    std::int64_t sent_ns = 0;
    if (pull_.recv(message)) std::memcpy(&sent_ns, message.data(), sizeof(sent_ns));
    return sent_ns;
  }

 private:
  zmq::context_t context_;
  zmq::socket_t push_{context_, zmq::socket_type::push}, pull_{context_, zmq::socket_type::pull};
};

class SharedMemoryChannel final : public Channel {
 public:
  SharedMemoryChannel(std::size_t num_bytes, void* memory)
      : Channel("shared memory, futex", num_bytes), shared_(new (memory) Shared), out_(num_bytes), in_(num_bytes) {}
  ~SharedMemoryChannel() override { munmap(shared_, sizeof(Shared) + num_bytes()); }

  static std::size_t Size(std::size_t num_bytes) { return sizeof(Shared) + num_bytes; }

  bool Send(std::int64_t now_ns) override {
    std::memcpy(out_.data(), &now_ns, sizeof(now_ns));
    std::memcpy(static_cast<void*>(shared_ + 1), out_.data(), out_.size());
    shared_->count.fetch_add(1, std::memory_order_release);
    syscall(SYS_futex, &shared_->count, FUTEX_WAKE, 1, nullptr, nullptr, 0);
    return true;
  }
  std::int64_t Receive() override {
    const timespec patience{0, kPatience_ms * 1'000'000};
    if (shared_->count.load(std::memory_order_acquire) == seen_) {
      syscall(SYS_futex, &shared_->count, FUTEX_WAIT, seen_, &patience, nullptr, 0);
    }
    const std::uint32_t count = shared_->count.load(std::memory_order_acquire);
    if (count == seen_) return 0;
    seen_ = count;
    std::memcpy(in_.data(), shared_ + 1, in_.size());
    std::int64_t sent_ns = 0;
    std::memcpy(&sent_ns, in_.data(), sizeof(sent_ns));
    return sent_ns;
  }

 private:
  struct Shared {
    std::atomic<std::uint32_t> count{0};
  };
  Shared* shared_;  // the payload stands behind it
  Bytes out_, in_;
  std::uint32_t seen_ = 0;
};

}  // namespace

std::unique_ptr<Channel> MakeUdp(std::size_t num_bytes) {
  auto near = bus::detail::UdpSocket::Bind("127.0.0.1");
  auto far = bus::detail::UdpSocket::Bind("127.0.0.1");
  if (!near || !far) return nullptr;
  return std::make_unique<UdpChannel>(num_bytes, std::move(*near), std::move(*far));
}

std::unique_ptr<Channel> MakeZeroMq(const std::string& name, const std::string& endpoint, std::size_t num_bytes) {
  try {
    return std::make_unique<ZeroMqChannel>(name, endpoint, num_bytes);
  } catch (const zmq::error_t&) {
    return nullptr;
  }
}

std::unique_ptr<Channel> MakeSharedMemory(std::size_t num_bytes) {
  void* const memory =
      mmap(nullptr, SharedMemoryChannel::Size(num_bytes), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  return std::make_unique<SharedMemoryChannel>(num_bytes, memory);
}

}  // namespace transport
