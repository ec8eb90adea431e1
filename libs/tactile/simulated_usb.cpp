#include "tactile/simulated_usb.hpp"

#include <algorithm>
#include <numeric>

namespace tactile {

class SimulatedUsb::Transport final : public UsbTransport {
 public:
  explicit Transport(SimulatedUsb* device) : device_(*device) {}

  bool Open(const UsbTable& table) override {
    const std::lock_guard lock(device_.mutex_);
    ++device_.motors_.scans;
    device_.table_ = table;
    device_.is_open_ = device_.is_plugged_;
    return device_.is_open_;
  }
  void Close() override { device_.Set(&device_.is_open_, false); }
  UsbOutcome Control(const ControlRequest& request, int /*timeout_ms*/) override {
    return device_.TakeControl(request);
  }
  UsbOutcome Write(std::span<const std::uint8_t> bytes, int /*timeout_ms*/) override {
    return device_.TakeFrame(bytes);
  }
  void ClearStall() override { device_.Set(&device_.is_stalled_, false); }
  [[nodiscard]] bool is_simulated() const override { return true; }

 private:
  SimulatedUsb& device_;
};

std::unique_ptr<UsbTransport> SimulatedUsb::Connect() {
  return std::make_unique<Transport>(this);
}

void SimulatedUsb::Set(bool* value, bool to) {
  const std::lock_guard lock(mutex_);
  *value = to;
}

// Unplugged, it has no power: its motors stop, and it has forgotten what it was told.
void SimulatedUsb::Plug(bool is_plugged) {
  const std::lock_guard lock(mutex_);
  is_plugged_ = is_plugged;
  is_open_ = false;
  watchdog_ns_ = 0;
  motors_.levels.clear();
}

UsbOutcome SimulatedUsb::TakeControl(const ControlRequest& request) {
  const std::lock_guard lock(mutex_);
  if (!is_open_) return UsbOutcome::kGone;
  if (swallows_) return UsbOutcome::kTimeout;
  if (request.request == kWatchdogRequest) watchdog_ns_ = std::int64_t{request.value} * 1'000'000;
  return UsbOutcome::kDone;
}

UsbOutcome SimulatedUsb::TakeFrame(std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  if (!is_open_) return UsbOutcome::kGone;
  if (swallows_) return UsbOutcome::kTimeout;
  std::vector<float> levels;
  if (is_stalled_ || !DecodeFrame(table_, bytes, &levels)) return UsbOutcome::kStall;
  motors_.levels = std::move(levels);
  ++motors_.frames;
  taken_ns_ = clock_();
  return UsbOutcome::kDone;
}

SimulatedUsb::Motors SimulatedUsb::motors() const {
  const std::lock_guard lock(mutex_);
  Motors motors = motors_;
  const bool is_silent = watchdog_ns_ > 0 && clock_() - taken_ns_ > watchdog_ns_;
  if (is_silent) std::fill(motors.levels.begin(), motors.levels.end(), 0.0f);
  return motors;
}

double SimulatedUsb::Motors::sum() const {
  return std::accumulate(levels.begin(), levels.end(), 0.0);
}

}  // namespace tactile
