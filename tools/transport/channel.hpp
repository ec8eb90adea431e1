#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace transport {

// Carries messages of one size from one thread to another. Each contains the time of its sending.
class Channel {
 public:
  Channel(std::string name, std::size_t num_bytes) : name_(std::move(name)), num_bytes_(num_bytes) {}
  virtual ~Channel() = default;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::size_t num_bytes() const { return num_bytes_; }  // of a message on the wire

  // Called by the sender's thread. `now_ns`: CLOCK_MONOTONIC. False if the message was not accepted.
  virtual bool Send(std::int64_t now_ns) = 0;
  // Called by the receiver's thread; waits 10 ms at most. Returns when the newest received message was sent [ns]; 0 if
  // none was received.
  virtual std::int64_t Receive() = 0;

 private:
  std::string name_;
  std::size_t num_bytes_;
};

using Channels = std::vector<std::unique_ptr<Channel>>;

constexpr int kPatience_ms = 10;

}  // namespace transport
