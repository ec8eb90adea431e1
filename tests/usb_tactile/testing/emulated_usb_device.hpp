#pragma once

#include <umockdev.h>

#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

namespace usb_tactile_tests {

// The kernel's side of /dev/bus/usb/001/004: a full-speed device 1209:0001 with one interface and an interrupt endpoint
// 1 towards it. One at a time, made before anything looks at USB. umockdev calls it from a thread of its own.
class EmulatedUsbDevice {
 public:
  EmulatedUsbDevice();
  ~EmulatedUsbDevice();
  EmulatedUsbDevice(const EmulatedUsbDevice&) = delete;
  EmulatedUsbDevice& operator=(const EmulatedUsbDevice&) = delete;

  void Plug();
  void Unplug();
  void Stall();  // until the halt is cleared
  void Swallow(bool does);

  using Bytes = std::vector<std::uint8_t>;
  [[nodiscard]] std::vector<Bytes> frames() const;
  [[nodiscard]] std::vector<Bytes> setups() const;  // eight bytes each
  [[nodiscard]] int halts_cleared() const;

 private:
  struct Urb;  // submitted, and not yet handed back
  static gboolean HandleIoctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client, EmulatedUsbDevice* self);
  void Submit(UMockdevIoctlClient* client);
  void Reap(UMockdevIoctlClient* client);
  void Discard(UMockdevIoctlClient* client);
  void TakeFrame(Urb* urb);
  void FinishSwallowed(int status);

  UMockdevTestbed* testbed_;
  UMockdevIoctlBase* handler_;
  mutable std::mutex mutex_;
  bool is_plugged_ = false;
  bool is_stalled_ = false;
  bool swallows_ = false;
  int halts_cleared_ = 0;
  std::deque<Urb*> finished_;
  std::deque<Urb*> swallowed_;
  std::vector<Bytes> frames_;
  std::vector<Bytes> setups_;
};

}  // namespace usb_tactile_tests
