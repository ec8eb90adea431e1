#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bus/membership/clock_bounds.hpp"
#include "bus/node.hpp"
#include "bus/rt/latest_value.hpp"
#include "core/messages/viewing.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/latency_log.hpp"
#include "nodes/visual_node/walls/kept_scenes.hpp"
#include "nodes/visual_node/walls/wall_link.hpp"
#include "scene/scenario.hpp"
#include "view/bus_feed.hpp"
#include "view/room.hpp"
#include "view/scene_mirror.hpp"
#include "view/scene_recorder.hpp"

namespace visual_node {

// Receives messages in a thread of its own and applies each to the scene at once, without waiting for a frame, so that
// t2_state does not depend on the speed of drawing. The drawing thread takes the newest complete scene.
class Receiver {
 public:
  Receiver(const scene::Scenario& scenario, LatencyLog* log) : scenario_(scenario), mirror_(scenario), log_(log) {}
  ~Receiver() { Stop(); }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  // Before Start: records what arrives, thinned (view/scene_recorder.hpp). Error: kIo.
  core::Result<void> Record(const std::filesystem::path& file);
  // Before Start: reads where that user's head is.
  void ReadHead(const std::string& user) { user_ = user; }
  // Before Start: keeps the newest states for JoinWalls's frames, and speaks to the other walls. `link` outlives the
  // receiver's thread.
  void JoinWalls(WallLink* link) { walls_ = link; }
  // Before Start: a person steers a hand from this viewer.
  void Steer() { steers_ = true; }
  // Viewers of one session need different names. Begin knocks at the registry, Join waits for its answer and begins to
  // receive: what takes long and needs no bus goes between both. Start is both.
  core::Result<void> Begin(const bus::NodeOptions& options);
  core::Result<void> Join();
  core::Result<void> Start(const bus::NodeOptions& options) {
    auto begun = Begin(options);
    return begun ? Join() : begun;
  }
  void Stop();
  // Says goodbye to the other nodes. Afterwards there is what was received, but no counters and bounds.
  void Leave();

  // Drawing thread: takes the newest scene. True when it is newer than the one before.
  bool Update() { return newest_.Update(); }
  [[nodiscard]] const view::Scene& scene() const { return newest_.value(); }
  // The newest head.
  [[nodiscard]] view::Head head() const;
  // Of walls, once started.
  [[nodiscard]] const KeptScenes& kept() const { return *kept_; }
  void SetWalls(double in_step, double apart_ms) {
    walls_in_step_.store(in_step, std::memory_order_relaxed);
    walls_apart_ms_.store(apart_ms, std::memory_order_relaxed);
  }

  // What is shown: of keys and the menu, and of parameters (`oos set`).
  [[nodiscard]] view::Choices choices() const;
  template <class Change>
  void Choose(Change&& change) {
    const std::scoped_lock lock(choices_mutex_);
    change(choices_);
  }
  // How often each camera's picture is wanted as a topic [1/s], by `oos set`. Index: Assets::cameras.
  [[nodiscard]] std::vector<double> image_rates_hz() const;
  void SendImage(CameraFeed::Seen seen);
  // What the person does now; only with Steer.
  void SendHand(const core::HandInput& input) { hand_.Write(input); }
  // Names of the pictures requested by events `screenshot` since the last call (the event's detail is the name).
  std::vector<std::string> TakeScreenshotRequests();
  void SetFramesPerSecond(double value) { frames_per_s_.store(value, std::memory_order_relaxed); }
  void SetRenderScale(double value) { render_scale_.store(value, std::memory_order_relaxed); }
  // The drawing thread has drawn a frame: announces it once by the event `ready`.
  void SetReady() { is_ready_.store(true, std::memory_order_release); }
  void SetFrames(std::uint64_t frames) { frames_.store(frames, std::memory_order_relaxed); }

  [[nodiscard]] const scene::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] bus::Counters counters() const { return node_->counters(); }
  [[nodiscard]] std::map<std::string, std::int64_t> clock_bounds_ns() const { return bus::ClockBounds(node_->Peers()); }
  [[nodiscard]] std::uint64_t num_states() const { return num_states_.load(std::memory_order_relaxed); }

 private:
  void Run();
  void TakeHead();
  void PumpWalls(std::int64_t now_ns);
  bool ApplyAll(std::int64_t now_ns);
  void TakeParameters();
  bool TakeChange(const core::ParameterChange& change, std::string* why);
  void SendImages();
  void SendHands(std::int64_t now_ns);
  void Publish(std::int64_t now_ns);
  void PublishFigures(std::int64_t now_ns);
  void RecordScene(std::int64_t now_ns);

  const scene::Scenario& scenario_;
  view::SceneMirror mirror_;
  LatencyLog* log_;
  std::unique_ptr<bus::Node> node_;
  std::optional<view::BusFeed> feed_;
  std::unique_ptr<view::SceneRecorder> recorder_;
  bus::StateWriter<bus::Figures> figures_;
  std::vector<bus::StateWriter<core::CameraImage>> cameras_;
  bool steers_ = false;
  bus::LatestWriter<core::HandInput> hand_writer_;
  bus::LatestValue<core::HandInput> hand_;
  std::int64_t hand_changed_ns_ = 0, hand_sent_ns_ = 0;
  core::Trace direct_;  // of the newest state, with this node's stamps
  core::Trace through_physics_;
  std::int64_t next_figures_ns_ = 0;
  std::int64_t next_publish_ns_ = 0;
  bool is_ready_announced_ = false;

  std::string user_;  // whose head is read; empty: nobody's
  const bus::LatestReader<core::HeadState>* head_reader_ = nullptr;
  mutable std::mutex head_mutex_;
  core::HeadState head_;
  std::int64_t head_received_ns_ = 0;  // 0: never
  WallLink* walls_ = nullptr;
  std::unique_ptr<KeptScenes> kept_;  // of a wall
  std::atomic<double> walls_in_step_{0.0}, walls_apart_ms_{0.0};

  bus::LatestValue<view::Scene> newest_;
  mutable std::mutex choices_mutex_;
  view::Choices choices_;
  std::vector<double> image_rates_hz_;
  std::vector<CameraFeed::Seen> images_;  // to be sent
  std::mutex requests_mutex_;
  std::vector<std::string> requests_;
  std::atomic<double> frames_per_s_{0.0};
  std::atomic<double> render_scale_{1.0};
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> num_states_{0};
  std::atomic<bool> is_ready_{false};
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace visual_node
