#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "tactile/usb_transport.hpp"

namespace tactile {

// SIMULATED: a tactile device in memory, of any table. It takes frames, refuses those that are none of its table, and
// stops its motors when frames stop, after the milliseconds of vendor request kWatchdogRequest.
class SimulatedUsb {
 public:
  static constexpr std::uint8_t kWatchdogRequest = 1;

  // `clock`: nanoseconds.
  explicit SimulatedUsb(std::function<std::int64_t()> clock) : clock_(std::move(clock)) {}

  // The way to it, which must not outlive it.
  std::unique_ptr<UsbTransport> Connect();

  void Plug(bool is_plugged);
  void Stall() { Set(&is_stalled_, true); }           // until it is cleared
  void Swallow(bool does) { Set(&swallows_, does); }  // it takes no frame and says nothing

  // As a person on the device feels it.
  struct Motors {
    std::vector<float> levels;  // empty: nothing came yet
    std::uint64_t frames = 0;
    std::uint64_t scans = 0;  // times that somebody looked for it
    [[nodiscard]] double sum() const;
  };
  [[nodiscard]] Motors motors() const;

 private:
  class Transport;
  void Set(bool* value, bool to);
  UsbOutcome TakeFrame(std::span<const std::uint8_t> bytes);
  UsbOutcome TakeControl(const ControlRequest& request);

  std::function<std::int64_t()> clock_;
  mutable std::mutex mutex_;
  UsbTable table_;
  bool is_plugged_ = true;
  bool is_stalled_ = false;
  bool swallows_ = false;
  bool is_open_ = false;
  std::int64_t watchdog_ns_ = 0;  // 0: none
  std::int64_t taken_ns_ = 0;
  Motors motors_;
};

}  // namespace tactile
