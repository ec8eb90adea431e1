#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "bus/rt/latency_stats.hpp"
#include "bus/rt/spsc_ring.hpp"
#include "core/messages/trace.hpp"
#include "core/result.hpp"

namespace visual_node {

// t2 as this node sees it, in two parts (architecture section 1). One row per sample, as every node writes them:
//   chain,trace_id,origin_ns,echo_ns,stage,offset_ns,stage,offset_ns,...
// with the numbers of core::Stage in the order of the hops, offsets since the device took the sample, and echo_ns -1:
// no second clock has measured it. Chains: t2_state (through a physics step in contact, until the state is applied),
// t2_state_direct (newest sample that physics had heard of, contact or not; every fourth has a row), t2_image (until
// the first frame that shows it is finished).
// Two threads share it without a lock: the receiving one must never wait for a disk or for a preempted drawing thread.
class LatencyLog {
 public:
  core::Result<void> Open(const std::filesystem::path& file);

  // --- Receiving thread. A state was applied. Ids that were there before count once; a trace without id does not.
  void AddState(const core::Trace& direct, const core::Trace& through_physics);

  // --- Drawing thread. A frame was finished that shows this newest state; stamped with kFrameStart and kFrameDone.
  void AddFrame(const core::Trace& through_physics);
  // Writes the rows of the states that were applied since.
  void Drain();

  // Moving means over about 250 states and 8 frames [ms]; 0 before the first. Any thread.
  [[nodiscard]] double recent_state_ms() const { return recent_state_ms_.load(std::memory_order_relaxed); }
  [[nodiscard]] double recent_image_ms() const { return recent_image_ms_.load(std::memory_order_relaxed); }

  // --- When both threads are done. All samples, also those whose rows found no room.
  [[nodiscard]] const bus::LatencyStats& state() const { return state_; }
  [[nodiscard]] const bus::LatencyStats& state_direct() const { return state_direct_; }
  [[nodiscard]] const bus::LatencyStats& image() const { return image_; }
  [[nodiscard]] std::uint64_t rows_without_room() const { return rows_.overflows(); }

 private:
  struct Row {
    const char* chain = "";
    core::Trace trace;
  };
  void Write(const char* chain, const core::Trace& trace);

  static constexpr std::size_t kMaxRowsWaiting = 4096;  // more than 3 s of states
  std::ofstream file_;
  bus::SpscRing<Row> rows_{kMaxRowsWaiting};
  bus::LatencyStats state_;
  bus::LatencyStats state_direct_;
  bus::LatencyStats image_;
  std::uint64_t last_through_id_ = 0;
  std::uint64_t last_direct_id_ = 0;
  std::uint64_t last_frame_id_ = 0;
  std::atomic<double> recent_state_ms_{0.0};
  std::atomic<double> recent_image_ms_{0.0};
};

}  // namespace visual_node
