#pragma once

#include <cmath>
#include <cstdint>

namespace device_bridge {

// Delay of one hand's force loop, from the device's sample to the time at which the force computed from it acts, and
// its jitter: moving averages of the delay and of its absolute deviation, which one late force hardly changes: alone it
// makes no loop unstable. Real-time safe.
class LoopDelay {
 public:
  // `device_s`: what the device itself needs from a write until the force acts.
  explicit LoopDelay(double device_s) : device_s_(device_s) {}

  void Add(std::int64_t delay_ns) noexcept {
    const double delay_s = static_cast<double>(delay_ns) * 1e-9 + device_s_;
    if (num_samples_ < kSamples) ++num_samples_;
    const double gain = 1.0 / num_samples_;
    mean_s_ += gain * (delay_s - mean_s_);
    jitter_s_ += gain * (std::abs(delay_s - mean_s_) - jitter_s_);
  }

  [[nodiscard]] bool is_measured() const { return num_samples_ >= kEnough; }
  [[nodiscard]] double mean_s() const { return mean_s_; }
  [[nodiscard]] double jitter_s() const { return jitter_s_; }
  // What a limit is computed with: a loop with jitter is no more stable than one that is always this late.
  [[nodiscard]] double late_s() const { return mean_s_ + 2.0 * jitter_s_; }

 private:
  // Free choices: the mean of half a second forgets a pause soon and is still a mean; before 64 samples the limit of
  // one late command would lower a stiffness that is fine.
  static constexpr int kSamples = 512;
  static constexpr int kEnough = 64;
  double device_s_;
  int num_samples_ = 0;
  double mean_s_ = 0.0;
  double jitter_s_ = 0.0;
};

}  // namespace device_bridge
