#include "nodes/visual_node/latency_log.hpp"

#include <system_error>

namespace visual_node {
namespace {

constexpr std::uint64_t kDirectStride = 4;  // every state has one, and only one in four gets a row; bounds the file

// Exponential moving average m <- (1 - w) m + w x, starting with the first sample. Each mean has one writing thread.
void UpdateMean(std::atomic<double>& mean_ms, double sample_ms, double weight) {
  const double old_ms = mean_ms.load(std::memory_order_relaxed);
  mean_ms.store(old_ms == 0.0 ? sample_ms : (1.0 - weight) * old_ms + weight * sample_ms, std::memory_order_relaxed);
}

}  // namespace

core::Result<void> LatencyLog::Open(const std::filesystem::path& file) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  file_.open(file);
  if (!file_) return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the folder writable?");
  file_ << "chain,trace_id,origin_ns,echo_ns,stages\n";
  return {};
}

void LatencyLog::Write(const char* chain, const core::Trace& trace) {
  if (!file_.is_open()) return;
  file_ << chain << ',' << trace.id << ',' << trace.origin_ns << ",-1";
  for (const core::Stamp& stamp : trace.stamps) {
    file_ << ',' << static_cast<int>(stamp.stage) << ',' << stamp.offset_ns;
  }
  file_ << '\n';
}

void LatencyLog::AddState(const core::Trace& direct, const core::Trace& through_physics) {
  if (direct.valid() && !direct.stamps.empty() && direct.id != last_direct_id_) {
    last_direct_id_ = direct.id;
    state_direct_.Add(direct.stamps.back().offset_ns);
    if (state_direct_.count() % kDirectStride == 1) rows_.Push({"t2_state_direct", direct});
  }
  if (through_physics.valid() && !through_physics.stamps.empty() && through_physics.id != last_through_id_) {
    last_through_id_ = through_physics.id;
    state_.Add(through_physics.stamps.back().offset_ns);
    UpdateMean(recent_state_ms_, 1e-6 * through_physics.stamps.back().offset_ns, 1.0 / 250.0);
    rows_.Push({"t2_state", through_physics});
  }
}

void LatencyLog::AddFrame(const core::Trace& trace) {
  if (!trace.valid() || trace.stamps.empty() || trace.id == last_frame_id_) return;
  last_frame_id_ = trace.id;
  image_.Add(trace.stamps.back().offset_ns);
  UpdateMean(recent_image_ms_, 1e-6 * trace.stamps.back().offset_ns, 1.0 / 8.0);
  Write("t2_image", trace);
}

void LatencyLog::Drain() {
  while (const Row* row = rows_.Front()) {
    Write(row->chain, row->trace);
    rows_.EndPop();
  }
}

}  // namespace visual_node
