#pragma once

#include <memory>

#include "tactile/usb_transport.hpp"

namespace tactile {

// A device at this machine's USB, by libusb. Each search lists the bus anew: in containers nobody tells of a device
// that is plugged in.
std::unique_ptr<UsbTransport> MakeLibusbTransport();

}  // namespace tactile
