#pragma once

#include <cmath>
#include <cstdint>

namespace device_bridge {

// Delay of one hand's force loop, from the device's sample to the time at which the force computed from it acts, and
// its jitter: moving averages of the delay and of its squared deviation. Real-time safe.
class LoopDelay {
 public:
  // `device_s`: what the device itself needs from a write until the force acts.
  explicit LoopDelay(double device_s) : device_s_(device_s) {}

  void Add(std::int64_t delay_ns) noexcept {
    const double delay_s = static_cast<double>(delay_ns) * 1e-9 + device_s_;
    if (!is_measured_) mean_s_ = delay_s;
    is_measured_ = true;
    const double deviation_s = delay_s - mean_s_;
    mean_s_ += kGain * deviation_s;
    variance_s2_ += kGain * (deviation_s * deviation_s - variance_s2_);
  }

  [[nodiscard]] bool is_measured() const { return is_measured_; }
  [[nodiscard]] double mean_s() const { return mean_s_; }
  [[nodiscard]] double jitter_s() const { return std::sqrt(variance_s2_); }  // standard deviation
  // What a limit is computed with: a loop with jitter is no more stable than one that is always this late.
  [[nodiscard]] double late_s() const { return mean_s_ + 2.0 * jitter_s(); }

 private:
  static constexpr double kGain = 1.0 / 512.0;  // half a second of samples; chosen
  double device_s_;
  bool is_measured_ = false;
  double mean_s_ = 0.0;
  double variance_s2_ = 0.0;
};

}  // namespace device_bridge
