#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace hug {

enum class FaultKind : std::uint8_t {
  kLoss,           // share of the commands that do not arrive
  kDelay,          // of commands [s]
  kJitter,         // further delay, evenly distributed up to this [s]
  kStuckSensor,    // position sensor at the motor of a joint repeats itself
  kEncoderJump,    // and here jumps by this [rad]
  kTorqueBias,     // one of the torque sensors of a joint is off by this [Nm]
  kForceBias,      // sensor at the wrist is off by this, along the base's x [N]
  kDeadManGlitch,  // reads as let go
  kClutchTrip,     // comes off
  kOverheat,       // of a motor
  kUnplug          // the machine does not answer
};

// A fault that is switched on for a while.
struct Fault {
  FaultKind kind = FaultKind::kLoss;
  double amount = 0.0;
  int joint = 0;  // 0 to 6
  double begin_s = 0.0;
  double end_s = 1e9;
};

// Reads "stuck_sensor joint 3 at 2 for 0.5; loss 0.2 at 1": a name, for some an amount, `joint` from 1, the begin `at`
// and the duration `for` in seconds since the machine was opened (default: from the begin, to the end). Error: which
// part is wrong, and the names that there are.
core::Result<std::vector<Fault>> ParseFaults(std::string_view text);

// The faults of one arm at a time.
class FaultSwitches {
 public:
  explicit FaultSwitches(std::vector<Fault> faults = {}) : faults_(std::move(faults)) {}
  [[nodiscard]] bool is_on(FaultKind kind, double time_s) const { return Find(kind, -1, time_s) != nullptr; }
  // The fault of this kind (and joint, unless it is -1) that is on now; null: none.
  [[nodiscard]] const Fault* Find(FaultKind kind, int joint, double time_s) const {
    for (const Fault& fault : faults_) {
      if (fault.kind == kind && (joint < 0 || fault.joint == joint) && time_s >= fault.begin_s &&
          time_s < fault.end_s) {
        return &fault;
      }
    }
    return nullptr;
  }
  [[nodiscard]] double Amount(FaultKind kind, double time_s) const {
    const Fault* fault = Find(kind, -1, time_s);
    return fault != nullptr ? fault->amount : 0.0;
  }

 private:
  std::vector<Fault> faults_;
};

}  // namespace hug
