#include "nodes/device_bridge/devices/link_meter.hpp"

#include <algorithm>

namespace device_bridge {

void LinkMeter::Received(const oos_device_state& state, std::int64_t now_ns) {
  if (last_ns_ != 0) longest_ns_ = std::max(longest_ns_, now_ns - last_ns_);
  last_ns_ = now_ns;
  ++num_samples_;
  lost_now_ = state.lost;
  // Only the first sample that knows a command: later ones are older news.
  if (state.reflected == 0 || state.reflected == reflected_) return;
  reflected_ = state.reflected;
  const std::int64_t sent_ns = sent_ns_[reflected_ % sent_ns_.size()];
  if (sent_ns == 0) return;
  round_trips_ns_ += now_ns - sent_ns;
  ++num_round_trips_;
}

bool LinkMeter::Update(std::int64_t now_ns) {
  if (begin_ns_ == 0) begin_ns_ = now_ns;
  const std::int64_t window_ns = now_ns - begin_ns_;
  if (window_ns < kWindow_ns) return false;
  figures_ = {};
  const auto samples = static_cast<double>(num_samples_);
  if (num_samples_ > 0) {
    figures_.rate_hz = samples * 1e9 / static_cast<double>(window_ns);
    figures_.jitter_s = std::max(0.0, static_cast<double>(longest_ns_) * 1e-9 - 1.0 / figures_.rate_hz);
    const auto lost = static_cast<double>(lost_now_ - std::min(lost_before_, lost_now_));
    figures_.loss = lost / (samples + lost);
  }
  if (num_round_trips_ > 0) {
    figures_.round_trip_s = static_cast<double>(round_trips_ns_) * 1e-9 / static_cast<double>(num_round_trips_);
  }
  begin_ns_ = now_ns;
  lost_before_ = lost_now_;
  num_samples_ = 0;
  longest_ns_ = round_trips_ns_ = num_round_trips_ = 0;
  return true;
}

}  // namespace device_bridge
