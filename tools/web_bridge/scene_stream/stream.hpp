#pragma once

#include <cstdint>
#include <optional>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/structures.hpp"
#include "scene/scenario.hpp"
#include "space/atmosphere/from_space.hpp"
#include "tools/web_bridge/scene_stream/frame.hpp"
#include "view/choices.hpp"
#include "view/scene.hpp"

namespace scene_stream {

// A picture in which nothing moves is sent this long after it was due: readers see that the stream lives.
constexpr std::int64_t kPeriodOfStills_ns = core::kNanosecondsPerSecond / 2;

// Writes assets once, then frames: at most `rate_hz` of them a second, and none while the reader has not taken the last
// one.
class Stream {
 public:
  Stream(const scene::Scenario& scenario, int file, const space::AirFromSpace& air);

  // Error: a mesh that cannot be read; the reader has gone.
  core::Result<void> Begin(const view::Scene& scene, double recording_s);

  void SetRate(double rate_hz) { period_ns_ = static_cast<std::int64_t>(1e9 / rate_hz); }
  [[nodiscard]] bool IsDue(std::int64_t now_ns) const { return now_ns >= next_ns_; }

  // What a frame says besides the scene.
  struct Moment {
    double at_s = 0.0;
    bool is_playing = true;
    double state_age_ms = 0.0;
  };
  // Error: the reader has gone.
  core::Result<void> Send(const view::Scene& scene, const view::Choices& choices, const Moment& moment,
                          std::int64_t now_ns);

 private:
  scene::Scenario scenario_;
  int file_;
  space::AirFromSpace air_;
  core::Result<void> block_result_;
  PointBlocks blocks_;
  FrameMaker maker_;
  visual_node::StructureShow structures_;
  std::uint64_t sheets_version_ = 0;
  std::int64_t period_ns_ = 10'000'000;  // twice a display's rate nearly, so that a state waits 5 ms in the mean
  std::int64_t next_ns_ = 0;
};

}  // namespace scene_stream
