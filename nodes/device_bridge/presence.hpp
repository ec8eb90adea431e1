#pragma once

#include <algorithm>
#include <cstdint>

#include "nodes/device_bridge/device_health.hpp"

namespace device_bridge {

// How long the bridge took to notice that a device was lost, and that it was there again, in its own steps: no busy
// machine changes them. A loss begins after the last sample. A return begins when the device was last known to be away:
// the last try to open it that failed, or, where there was nothing to open, the last step without a sample.
class Presence {
 public:
  void Step(const DeviceHealth& health, std::int64_t sample_ns) noexcept {
    ++step_;
    const bool is_alive = health.status == DeviceStatus::kAlive;
    const bool has_sample = sample_ns != sample_ns_ || sample_ns == 0;  // 0: each step is a sample
    if (was_alive_ && !is_alive) Lose();
    if (!was_alive_ && is_alive) Find();
    if (is_alive && has_sample) sample_step_ = step_;
    const bool is_opened = health.status == DeviceStatus::kWaiting || health.status == DeviceStatus::kSilent;
    if (!is_alive && (health.num_misses != num_misses_ || health.status == DeviceStatus::kHung ||
                      (is_opened && sample_ns == sample_ns_))) {
      away_step_ = step_;
    }
    was_alive_ = is_alive;
    sample_ns_ = sample_ns;
    num_misses_ = health.num_misses;
  }

  [[nodiscard]] std::uint64_t num_losses() const { return num_losses_; }
  // Of the latest loss and return; 0: none.
  [[nodiscard]] std::uint64_t steps_to_lost() const { return steps_to_lost_; }
  [[nodiscard]] std::uint64_t steps_to_found() const { return steps_to_found_; }
  [[nodiscard]] std::uint64_t most_steps_to_lost() const { return most_steps_to_lost_; }
  [[nodiscard]] std::uint64_t most_steps_to_found() const { return most_steps_to_found_; }

 private:
  void Lose() noexcept {
    ++num_losses_;
    steps_to_lost_ = step_ - sample_step_;
    most_steps_to_lost_ = std::max(most_steps_to_lost_, steps_to_lost_);
    away_step_ = step_;
  }
  void Find() noexcept {
    if (num_losses_ == 0) return;  // the first time it was not away
    steps_to_found_ = step_ - away_step_;
    most_steps_to_found_ = std::max(most_steps_to_found_, steps_to_found_);
  }

  std::uint64_t step_ = 0, sample_step_ = 0, away_step_ = 0;
  bool was_alive_ = false;
  std::int64_t sample_ns_ = 0;
  std::uint64_t num_misses_ = 0;
  std::uint64_t num_losses_ = 0, steps_to_lost_ = 0, steps_to_found_ = 0;
  std::uint64_t most_steps_to_lost_ = 0, most_steps_to_found_ = 0;
};

}  // namespace device_bridge
