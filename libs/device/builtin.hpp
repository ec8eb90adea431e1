#pragma once

#include "device/plugin.h"

namespace device {

// Devices that are compiled in.
const oos_device_plugin& UdpPlugin();  // frames over UDP; address: PORT or ADDRESS:PORT to listen at
const oos_device_plugin&
SerialPlugin();  // the same frames over a serial line; address: /dev/ttyUSB0 or /dev/ttyUSB0:115200

}  // namespace device
