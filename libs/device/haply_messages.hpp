#pragma once

#include <string>
#include <string_view>

#include "device/plugin.h"

namespace device {

// The messages of Haply's Inverse Service, version 3.1 and later: JSON over a WebSocket at port 10001. Of them this
// project uses an Inverse3's place and velocity, and of a grip beside it orientation and buttons. From what its users
// publish; no hardware was there.

// What one message says.
struct HaplyState {
  std::string device_id;  // of the Inverse3; empty: the message has none
  double position_m[3] = {};
  double velocity_m_per_s[3] = {};
  double quaternion[4] = {1, 0, 0, 0};  // w, x, y, z of the grip
  bool has_grip = false;
  std::uint64_t buttons = 0;
};

// Reads foreign text: any is allowed. False: it is not such a message, or a number in it is not finite.
bool ReadHaplyState(std::string_view text, HaplyState* state);

// The service answers a force with the next state, so one is sent for each.
std::string WriteHaplyForce(const std::string& device_id, const double (&force_N)[3]);

}  // namespace device
