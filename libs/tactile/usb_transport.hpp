#pragma once

#include <cstdint>
#include <span>

#include "tactile/usb_table.hpp"

namespace tactile {

enum class UsbOutcome {
  kDone,
  kTimeout,  // the device took nothing
  kStall,    // its endpoint has halted
  kGone,     // unplugged
  kFailed,
};

// Interface of the way to a USB device: libusb, or memory. Calls wait for the device, so they are made by a thread that
// nobody waits for. Not thread-safe.
class UsbTransport {
 public:
  virtual ~UsbTransport() = default;

  // Looks for the device and takes its interface. False: it is not there, or somebody else has it.
  virtual bool Open(const UsbTable& table) = 0;
  virtual void Close() = 0;
  virtual UsbOutcome Control(const ControlRequest& request, int timeout_ms) = 0;
  virtual UsbOutcome Write(std::span<const std::uint8_t> bytes, int timeout_ms) = 0;
  // After kStall: the endpoint takes frames again.
  virtual void ClearStall() = 0;

  [[nodiscard]] virtual bool is_simulated() const = 0;
};

}  // namespace tactile
