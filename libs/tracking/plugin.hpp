#pragma once

#include "device/plugin.h"

namespace tracking {

// A Flystick, or a hand with fingers, of ART's DTrack as a hand device without force. Address: where DTrack sends, PORT
// or GROUP:PORT. Options: README.md of this room.
const oos_device_plugin& Plugin();

}  // namespace tracking
