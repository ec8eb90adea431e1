#pragma once

#include <atomic>
#include <cstdint>

#include "bus/node.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "tools/web_bridge/scene_stream/commands.hpp"
#include "tools/web_bridge/scene_stream/stream.hpp"
#include "view/bus_feed.hpp"
#include "view/hand_steering.hpp"
#include "view/scene_mirror.hpp"

namespace scene_stream {

// Streams a session that runs, until it is stopped. A visual node like others: what it shows are its parameters, and it
// publishes a digest of it.
class Live {
 public:
  Live(const scene::Scenario& scenario, Stream* stream, CommandLines* commands)
      : scenario_(scenario), mirror_(scenario), stream_(stream), commands_(commands) {}

  core::Result<void> Run(const bus::NodeOptions& options, const std::atomic<int>& interrupted);

 private:
  core::Result<void> Join(const bus::NodeOptions& options, bool steers);
  core::Result<void> Step();
  void TakeCommands();
  void TakeHand(const Command::Hand& hand);
  void TakeParameters();
  void PublishFigures(std::int64_t now_ns);

  const scene::Scenario& scenario_;
  view::SceneMirror mirror_;
  view::Choices choices_;
  Stream* stream_;
  CommandLines* commands_;
  std::unique_ptr<bus::Node> node_;
  std::optional<view::BusFeed> feed_;
  bus::StateWriter<bus::Figures> figures_;
  bus::LatestWriter<core::HandInput> hand_writer_;
  view::HandSteering steering_;
  bool steers_ = false, shows_next_ = false;
  scene::Camera hand_camera_;  // of the page that steers
  std::int64_t next_figures_ns_ = 0;
  std::uint64_t num_states_ = 0;
  bool is_changed_ = true;
};

}  // namespace scene_stream
