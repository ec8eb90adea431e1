#pragma once

#include <array>
#include <cstdint>

namespace device_bridge {

enum class DeviceStatus : std::uint8_t {
  kWaiting,  // has not been there yet
  kAlive,
  kSilent,  // no sample for 60 ms
  kGone,    // unplugged, or its program has ended
  kHung,    // a call of the plug-in has not returned for 60 ms
  kBroken,  // threw, or wrote numbers that are not finite: off for the rest of the run
};
const char* NameOf(DeviceStatus status);

// Of the link to a device, over half a second.
struct LinkFigures {
  double rate_hz = 0.0;
  double jitter_s = 0.0;      // largest distance of two samples, less their mean distance
  double loss = 0.0;          // share of the samples that never arrived
  double round_trip_s = 0.0;  // from a command to the sample that knows it, mean; 0: the device does not tell
};

// As FRI's classes of quality [KUKA]: judged by the worst figure. The bounds are chosen without a study.
enum class LinkQuality : std::uint8_t { kOff, kPoor, kFair, kGood, kExcellent };
LinkQuality QualityOf(const LinkFigures& figures);
const char* NameOf(LinkQuality quality);

struct DeviceHealth {
  DeviceStatus status = DeviceStatus::kWaiting;
  LinkFigures link;
  LinkQuality quality = LinkQuality::kOff;
  std::array<char, 200> why{};   // what is wrong, ended by 0
  std::uint64_t num_misses = 0;  // times that it was looked for and was not there
  bool is_calibrated = false;
  double residual_m = 0.0;  // of the calibration
};

}  // namespace device_bridge
