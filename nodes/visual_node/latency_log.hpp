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

// Measures the latency t2 in two parts (architecture section 1). One CSV row per sample, in the format of all nodes:
//   chain,trace_id,origin_ns,echo_ns,stage,offset_ns,stage,offset_ns,...
// with the numbers of core::Stage in the order of the hops, offsets from the device's sample, and echo_ns -1, as there
// is no independent measurement. Chains: t2_state (from a sample that acted on physics in contact until its state is
// applied), t2_state_direct (from the newest sample that physics had received; one in four has a row), t2_image (until
// the first frame that shows the state is finished). Two threads share the log without a lock, because the receiving
// thread must never wait for the disk or for the drawing thread.
class LatencyLog {
 public:
  core::Result<void> Open(const std::filesystem::path& file);

  // --- Receiving thread. Records an applied state. Each trace id counts once, a trace without id not at all.
  void AddState(const core::Trace& direct, const core::Trace& through_physics);

  // --- Drawing thread. Records a finished frame that shows this state, stamped with kFrameStart and kFrameDone.
  void AddFrame(const core::Trace& through_physics);
  // Writes the rows of the states that were applied since the last call.
  void Drain();
  // Nothing is written any more.
  void Close() { file_.close(); }

  // Moving means over about 250 states and 8 frames [ms]; 0 before the first. Any thread.
  [[nodiscard]] double recent_state_ms() const { return recent_state_ms_.load(std::memory_order_relaxed); }
  [[nodiscard]] double recent_image_ms() const { return recent_image_ms_.load(std::memory_order_relaxed); }

  // --- After both threads have ended. All samples, including those without a row for lack of room.
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

  static constexpr std::size_t kMaxRowsWaiting = 4096;  // over 3 s of states at 1.25 rows each: longer than any frame
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
