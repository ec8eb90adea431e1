#pragma once

#include "device/plugin.h"

namespace device_bridge {

// SIMULATED: a hand without a motor before a tracker, as device type "simulated_hand". The operator's hand goes where
// it wants to, because nothing holds it. The cameras see it sixty times a second, with noise; they say where it is, and
// the jaws close in the person's place by one of the methods of pseudo-haptics (tracking/pseudo_grip.hpp), which a real
// tracker's device uses as well. The person sees the jaws stop on what is between them, and then draws the stick,
// closes the fingers, or pinches, as hard as it wants to grip.
//
// With "fingers" it wears a glove, or its fingers are tracked: the angles of a person's fingers who holds something as
// wide as the operator wants the jaws open, for a hand with fingers (scenarios/parts/README.md). They press as far as
// the person closes them beyond what is between them.
//
// Options: grip = "stick" (default), "distance", "pinch" or "fingers".
const oos_device_plugin& SimulatedHandPlugin();

}  // namespace device_bridge
