#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "bus/membership/roster.hpp"
#include "bus/rt/latency_stats.hpp"
#include "core/result.hpp"

namespace visual_node {

// This node's part of the run's report, visual_node.json.
struct Summary {
  std::string scenario;
  std::string gl_renderer;
  std::size_t num_triangles = 0;
  std::uint64_t frames = 0;
  double seconds = 0.0;
  double render_scale_sum = 0.0;  // over all frames
  double cpu_s = 0.0;             // of all threads, from the first frame to the last
  std::uint64_t states = 0;       // physics states applied
  bus::LatencyStats draw;         // start of drawing until glFinish
  bus::LatencyStats t2_state;
  bus::LatencyStats t2_state_direct;
  bus::LatencyStats t2_image;
  bus::Counters counters;
  std::map<std::string, std::int64_t> clock_bounds_ns;  // bus/membership/clock_bounds.hpp

  core::Result<void> Write(const std::filesystem::path& file) const;
};

}  // namespace visual_node
