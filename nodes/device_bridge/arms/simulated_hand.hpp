#pragma once

#include "device/plugin.h"

namespace device_bridge {

// SIMULATED: a hand without a motor before a tracker, as device type "simulated_hand". The operator's hand goes where
// it wants to, because nothing holds it. The cameras see it sixty times a second, with noise; they say where it is, and
// the jaws close in the person's place by one of the methods of pseudo-haptics (tracking/pseudo_grip.hpp), which a real
// tracker's device uses as well. The person sees the jaws stop on what is between them, and then draws the stick,
// closes the fingers, or pinches, as hard as it wants to grip.
//
// Options: grip = "stick" (default), "distance" or "pinch".
const oos_device_plugin& SimulatedHandPlugin();

}  // namespace device_bridge
