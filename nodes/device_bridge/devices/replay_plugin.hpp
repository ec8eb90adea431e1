#pragma once

#include "device/plugin.h"

namespace device_bridge {

// A recording as a device: type "replay", address: an MCAP file of a run, with a colon and a role when the recorded
// role has another name. It moves as the recorded device did, from the first step on, and then stands still, let go. It
// has no motors. Its base is W of the recorded scene.
const oos_device_plugin& ReplayPlugin();

}  // namespace device_bridge
