#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "bus/node.hpp"
#include "core/messages/rays.hpp"
#include "nodes/rt_worker/drawer.hpp"

namespace rt_worker {

// Draws what a viewer asks of its seat. It may begin, end and be killed at any time: the viewer asks somebody else.
class Worker {
 public:
  // Declares its topics, so it is made before the node's Start. Both outlive it.
  Worker(const std::string& viewer, std::size_t seat, Drawer* drawer, bus::Node* node);

  // Until `stop`.
  void Run(const std::atomic<bool>& stop);
  // Draws the next tile of the list, if there is one. Messages were received by the node's last Wait.
  bool Step();
  // It has jobs of a frame that has not come yet.
  [[nodiscard]] bool is_waiting() const { return is_waiting_; }
  // By any thread.
  [[nodiscard]] std::uint64_t num_tiles() const { return num_tiles_.load(std::memory_order_relaxed); }

 private:
  [[nodiscard]] const core::RayJob* NextJob(const core::RayFrame** frame);
  void Forget(std::uint64_t job) { answered_[num_answered_++ % answered_.size()] = job; }

  static constexpr std::size_t kKeys = 16;  // more than a list has jobs, so that no answer replaces one under way
  Drawer* drawer_;
  bus::Node* node_;
  bus::StateReader<core::RayFrame>* frames_;
  bus::LatestReader<core::RayJobs>* jobs_;
  bus::StateWriter<core::RayTile> tiles_;
  std::array<std::uint64_t, 64> answered_{};  // the newest jobs that are done with
  std::size_t num_answered_ = 0;
  std::atomic<std::uint64_t> num_tiles_{0};
  bool is_waiting_ = false;
  core::RayTile answer_;
};

}  // namespace rt_worker
