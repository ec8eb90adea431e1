#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/walls/barrier.hpp"
#include "nodes/visual_node/walls/named_tick.hpp"
#include "nodes/visual_node/walls/wall_link.hpp"
#include "view/room.hpp"

namespace visual_node {

// Keeps the walls of a room in step. For each frame the first wall names a physics state that all have, the camera's
// place and the head; all draw it; when all have, the first wall names the moment from which all show it. A wall that
// hears nothing of the first one for 0.3 s goes on by itself, with the newest state, until it hears of it again.
//
// All calls come from the drawing thread, for each frame: Begin, draw, AwaitShow, show, Shown.
class Walls {
 public:
  struct Frame {
    std::uint64_t number = 0;
    std::uint64_t tick = 0;  // of the physics state to draw; 0: the newest
    core::Pose X_WR;
    core::Pose X_RH;
    double eye_distance_m = 0.0;
    bool is_in_step = true;
  };

  // `is_stopped`: ends every wait.
  Walls(WallLink* link, std::function<bool()> is_stopped);

  // Of the first wall: the physics state of the next frame.
  std::uint64_t NextTick(const KeptTicks& own);
  // The next frame. `wish`: of the first wall, which decides for all; the others take tick, place and head from it,
  // and wait for it.
  Frame Begin(const Frame& wish);
  // The picture is complete, of that state. Waits until all have theirs and the moment has come.
  void AwaitShow(std::uint64_t tick);
  void Shown();

  // For a line of text and figures.
  [[nodiscard]] bool is_in_step() const { return frame_.is_in_step; }
  [[nodiscard]] bool is_led() const { return is_in_step() && !link_->place().is_first(); }
  [[nodiscard]] std::string Describe() const;
  [[nodiscard]] std::size_t num_in_step() const { return num_in_step_; }  // this one included
  [[nodiscard]] double apart_ms() const { return apart_ms_; }  // of the newest frame that all have shown; first wall

  // frame, tick, shown_ns (this host's CLOCK_MONOTONIC), in_step. Error: kIo.
  core::Result<void> Write(const std::filesystem::path& file) const;

 private:
  static constexpr std::int64_t kLead_ns = 3'000'000;        // between the message that names the moment and the moment
  static constexpr std::int64_t kMostSleep_ns = 50'000'000;  // however wrong a clock is

  void AwaitOthers();
  void AwaitFirst();
  void Compare();

  struct Row {
    std::uint64_t frame, tick;
    std::int64_t shown_ns;
    bool is_in_step;
  };

  WallLink* link_;
  std::function<bool()> is_stopped_;
  Barrier barrier_;
  NamedTick named_tick_;
  core::WallFrame named_;  // by the first wall
  core::WallState own_;
  Frame frame_;
  std::int64_t show_ns_ = 0;
  std::vector<Row> rows_;
  std::size_t num_in_step_ = 1;
  double apart_ms_ = 0.0;
};

}  // namespace visual_node
