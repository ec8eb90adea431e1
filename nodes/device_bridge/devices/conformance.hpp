#pragma once

#include <functional>
#include <string>
#include <vector>

#include "nodes/device_bridge/device.hpp"

namespace device_bridge {

enum class Verdict { kHolds, kFails, kSkipped };

struct ConformanceFinding {
  std::string subject;  // rate, jitter, loss, ...
  Verdict verdict = Verdict::kSkipped;
  std::string what;  // the figure; when it fails or is skipped also why, and the remedy
};

struct ConformanceOptions {
  double force_N = 1.0;  // pushed for the check: no sample is above it
  // Now, and a wait until then; a device in virtual time needs none.
  std::function<std::int64_t()> clock;
  std::function<void(std::int64_t)> wait_until;
  std::function<bool()> is_interrupted;
};

// Checks that a device keeps to device/plugin.h and is good enough for a hand: rate, jitter, loss, round trip, units,
// force as commanded, guidance to a goal if it leads, no force above the limit whatever is commanded, its own watchdog.
// Lasts some eight seconds. For the checks with force its dead-man must be held.
std::vector<ConformanceFinding> CheckConformance(Device* device, const ConformanceOptions& options);

}  // namespace device_bridge
