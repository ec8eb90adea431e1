#pragma once

#include <cstdint>

#include "core/messages/trace.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace core {

// device/<role>/state: one sample of a hand device. D is the device's hand frame, which coincides with the origin of
// the hand's palm object.
struct DeviceState {
  Header header;
  std::uint8_t role_index = 0;
  std::int64_t sample_ns = 0;
  Pose X_WD;
  Twist V_WD;
  double opening_m = 0.0;  // gap between the jaws; 0 for a device without a gripper
  double opening_velocity_m_per_s = 0.0;
  bool is_engaged = false;  // dead-man held
  bool is_simulated = true;
};

// device/<role>/command: what the hand shall feel.
struct DeviceCommand {
  Header header;
  std::uint8_t role_index = 0;
  Wrench F_Do_W;                          // on the hand, about the device's hand frame origin
  double grip_force_N = 0.0;              // opens the jaws when positive
  std::int64_t validity_ns = 10'000'000;  // after this age the bridge fades the force out
};

}  // namespace core
