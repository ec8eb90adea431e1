#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/messages/device.hpp"
#include "tactile/usb_transport.hpp"

namespace tactile {

// How strong the channels shall be, and when that was decided.
struct Strengths {
  std::array<float, core::kMaxTactileChannels> levels{};
  std::int64_t made_ns = 0;
};

enum class DriverStatus : std::uint8_t { kWaiting, kAlive, kNotAnswering, kGone };
const char* NameOf(DriverStatus status);

struct DriverState {
  DriverStatus status = DriverStatus::kWaiting;
  std::uint64_t frames = 0;                               // taken by the device
  std::uint64_t errors = 0;                               // not taken
  std::array<float, core::kMaxTactileChannels> levels{};  // of the newest frame that was taken
};

// Drives a tactile USB device, whatever happens to it: looks for it, sets it up, sends frames, clears stalls, and looks
// again when it is gone. No thread and no clock: call Turn every kTurn_ns.
class UsbDriver {
 public:
  using Input = Strengths;
  using State = DriverState;

  UsbDriver(UsbTable table, std::unique_ptr<UsbTransport> transport);
  ~UsbDriver();
  UsbDriver(const UsbDriver&) = delete;
  UsbDriver& operator=(const UsbDriver&) = delete;

  // What was decided longer than kSilence_ns ago counts as nothing: all motors off.
  void Take(const Strengths& strengths) { strengths_ = strengths; }
  void Turn(std::int64_t now_ns);
  // A last frame without strengths. The device is let go.
  void Stop();

  [[nodiscard]] const DriverState& state() const { return state_; }
  [[nodiscard]] const UsbTable& table() const { return table_; }

  static constexpr std::int64_t kTurn_ns = 4'000'000;
  // 40 + 4 ms until a frame of zeros, and a frame's time-out, are below the 60 ms within which motors must be off.
  static constexpr std::int64_t kSilence_ns = 40'000'000;
  static constexpr int kTimeout_ms = 10;
  static constexpr std::int64_t kScan_ns = 200'000'000;  // 5/s while the device is not there
  // A frame while all is off, which tells whether the device is still there.
  static constexpr std::int64_t kIdle_ns = 200'000'000;
  static constexpr int kMostFailures = 25;  // one after another: then it is opened anew

 private:
  void LookForDevice(std::int64_t now_ns);
  void SetUp();
  void LetGo(DriverStatus status);
  void Send(std::int64_t now_ns);
  void TakeFailure(UsbOutcome outcome);

  UsbTable table_;
  std::unique_ptr<UsbTransport> transport_;
  Strengths strengths_;
  DriverState state_;
  bool is_open_ = false;
  int failures_ = 0;
  std::int64_t next_scan_ns_ = 0;
  std::int64_t sent_ns_ = 0;
  std::vector<std::uint8_t> sent_;  // newest frame that was taken; empty: none since it was opened
  std::vector<std::uint8_t> frame_;
};

}  // namespace tactile
