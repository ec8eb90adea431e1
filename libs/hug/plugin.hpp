#pragma once

#include "device/plugin.h"

namespace hug {

// A SIMULATED HUG as devices of device/plugin.h, one for each arm: roles "right" and "left", or option `arm`. Devices
// that were opened with the same option `session` are arms of one machine. Options: README.md of this room.
const oos_device_plugin& Plugin();

}  // namespace hug
