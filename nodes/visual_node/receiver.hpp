#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bus/clock_bounds.hpp"
#include "bus/node.hpp"
#include "bus/rt/latest_value.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/latency_log.hpp"
#include "scene/scenario.hpp"
#include "view/bus_feed.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {

// Takes messages off the bus in its own thread and applies each to the scene at once, never waiting for a frame:
// t2_state must not measure how fast pictures are drawn. The drawing thread takes the newest complete scene.
class Receiver {
 public:
  Receiver(const scene::Scenario& scenario, LatencyLog* log) : scenario_(scenario), mirror_(scenario), log_(log) {}
  ~Receiver() { Stop(); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  // Two viewers of one session have different names.
  core::Result<void> Start(const bus::NodeOptions& options);
  void Stop();

  // Drawing thread: true when a newer scene than before has been taken over.
  bool Update() { return newest_.Update(); }
  [[nodiscard]] const view::Scene& scene() const { return newest_.value(); }
  // Names of pictures asked for by event `screenshot` since the last call (detail: the name).
  std::vector<std::string> TakeScreenshotRequests();
  void SetFramesPerSecond(double value) { frames_per_s_.store(value, std::memory_order_relaxed); }
  // The drawing thread is ready to show: told to the others once.
  void SetReady() { is_ready_.store(true, std::memory_order_release); }
  void SetFrames(std::uint64_t frames) { frames_.store(frames, std::memory_order_relaxed); }

  [[nodiscard]] bus::Counters counters() const { return node_->counters(); }
  [[nodiscard]] std::map<std::string, std::int64_t> clock_bounds_ns() const { return bus::ClockBounds(node_->Peers()); }
  [[nodiscard]] std::uint64_t num_states() const { return num_states_.load(std::memory_order_relaxed); }

 private:
  void Run();
  bool ApplyAll(std::int64_t now_ns);
  void Publish(std::int64_t now_ns);
  void TellFigures(std::int64_t now_ns);

  const scene::Scenario& scenario_;
  view::SceneMirror mirror_;
  LatencyLog* log_;
  std::unique_ptr<bus::Node> node_;
  std::optional<view::BusFeed> feed_;
  bus::StateWriter<bus::Figures> figures_;
  core::Trace direct_;  // of the newest state, with this node's stamps
  core::Trace through_physics_;
  std::int64_t next_figures_ns_ = 0;
  std::int64_t next_publish_ns_ = 0;
  bool is_ready_told_ = false;

  bus::LatestValue<view::Scene> newest_;
  std::mutex requests_mutex_;
  std::vector<std::string> requests_;
  std::atomic<double> frames_per_s_{0.0};
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> num_states_{0};
  std::atomic<bool> is_ready_{false};
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace visual_node
