#pragma once

#include "device/plugin.h"

namespace device {

// Devices that are compiled in.
const oos_device_plugin& UdpPlugin();  // frames over UDP; address: PORT or ADDRESS:PORT to listen at
const oos_device_plugin&
SerialPlugin();  // the same frames over a serial line; address: /dev/ttyUSB0 or /dev/ttyUSB0:115200
const oos_device_plugin& HaplyPlugin();  // an Inverse3, by its maker's service; address: 127.0.0.1:10001

}  // namespace device
