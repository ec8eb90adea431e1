#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "bus/rt/latency_stats.hpp"
#include "core/messages/trace.hpp"
#include "core/result.hpp"

namespace visual_node {

// t2 as this node sees it, in two parts (architecture section 1). One row per sample, as every node writes them:
//   chain,trace_id,origin_ns,echo_ns,stage,offset_ns,stage,offset_ns,...
// with the numbers of core::Stage in the order of the hops, offsets since the device took the sample, and echo_ns -1:
// no second clock has measured it. Chains: t2_state (through a physics step in contact, until the state is applied),
// t2_state_direct (newest sample that physics had heard of, contact or not; every fourth has a row), t2_image (until
// the first frame that shows it is finished). Any thread.
class LatencyLog {
 public:
  core::Result<void> Open(const std::filesystem::path& file);

  // A state was applied. Ids that were there before count once. Returns without a row for a trace without id.
  void AddState(const core::Trace& direct, const core::Trace& through_physics);
  // A frame was finished that shows this newest state; stamped with kFrameStart and kFrameDone.
  void AddFrame(const core::Trace& through_physics);

  [[nodiscard]] bus::LatencyStats state() const;
  [[nodiscard]] bus::LatencyStats state_direct() const;
  [[nodiscard]] bus::LatencyStats image() const;
  // Moving means over about 250 states and 8 frames [ms]; 0 before the first.
  [[nodiscard]] double recent_state_ms() const;
  [[nodiscard]] double recent_image_ms() const;

 private:
  void Write(const char* chain, const core::Trace& trace);

  mutable std::mutex mutex_;
  std::ofstream file_;
  bus::LatencyStats state_;
  bus::LatencyStats state_direct_;
  bus::LatencyStats image_;
  std::uint64_t last_through_id_ = 0;
  std::uint64_t last_direct_id_ = 0;
  std::uint64_t last_frame_id_ = 0;
  double recent_state_ms_ = 0.0;
  double recent_image_ms_ = 0.0;
};

}  // namespace visual_node
