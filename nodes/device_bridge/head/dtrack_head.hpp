#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "bus/rt/latest_value.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/head/head_tracker.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// A head by ART's DTrack: a body (target) on glasses or helmet, from datagrams that a thread of its own receives. T is
// the tracker's room frame, B the body: X_RH = X_RT X_TB X_BH, where H has B's axes and its origin between the eyes.
class DtrackHead final : public HeadTracker {
 public:
  // Error: kInvalidInput for an address that is none, kIo when nothing can be received there.
  static core::Result<std::unique_ptr<DtrackHead>> Create(const scene::User& user);
  ~DtrackHead() override;
  DtrackHead(const DtrackHead&) = delete;
  DtrackHead& operator=(const DtrackHead&) = delete;

  std::optional<core::Pose> Read(std::int64_t now_ns) noexcept override;
  [[nodiscard]] bool is_simulated() const override { return false; }
  [[nodiscard]] const char* description() const override { return description_.c_str(); }

  // By any thread: where it listens, and how many datagrams it has read.
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::uint64_t num_read() const { return num_read_.load(); }

 private:
  DtrackHead(const scene::User& user, int socket, int wake_fd, std::uint16_t port);
  void Run();
  void Take(std::string_view datagram);

  int socket_, wake_fd_;
  std::uint16_t port_;
  int body_;
  core::Pose X_RT_, X_BH_;
  std::string description_;
  std::uint64_t num_bad_ = 0;
  bus::LatestValue<core::Pose> poses_TB_;
  std::atomic<std::uint64_t> num_read_{0};
  std::atomic<bool> is_stop_wanted_{false};
  std::thread thread_;
};

}  // namespace device_bridge
