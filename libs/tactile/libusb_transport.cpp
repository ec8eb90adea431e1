#include "tactile/libusb_transport.hpp"

#include <libusb.h>

#include <algorithm>
#include <vector>

namespace tactile {
namespace {

UsbOutcome OutcomeOf(int error) {
  switch (error) {
    case LIBUSB_ERROR_TIMEOUT:
      return UsbOutcome::kTimeout;
    case LIBUSB_ERROR_PIPE:
      return UsbOutcome::kStall;
    case LIBUSB_ERROR_NO_DEVICE:
      return UsbOutcome::kGone;
    default:
      return error >= 0 ? UsbOutcome::kDone : UsbOutcome::kFailed;
  }
}

// The kernel takes interrupt transfers on interrupt endpoints only.
bool IsInterruptEndpoint(libusb_device_handle* handle, std::uint8_t endpoint) {
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(libusb_get_device(handle), &config) != 0) return true;
  bool is_interrupt = true;
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    for (int j = 0; j < config->interface[i].num_altsetting; ++j) {
      const libusb_interface_descriptor& setting = config->interface[i].altsetting[j];
      for (int k = 0; k < setting.bNumEndpoints; ++k) {
        if (setting.endpoint[k].bEndpointAddress != endpoint) continue;
        is_interrupt = (setting.endpoint[k].bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_TRANSFER_TYPE_INTERRUPT;
      }
    }
  }
  libusb_free_config_descriptor(config);
  return is_interrupt;
}

class LibusbTransport final : public UsbTransport {
 public:
  LibusbTransport() = default;
  ~LibusbTransport() override { Close(); }
  LibusbTransport(const LibusbTransport&) = delete;
  LibusbTransport& operator=(const LibusbTransport&) = delete;

  bool Open(const UsbTable& table) override {
    Close();
    if (libusb_init(&context_) != 0) return false;
    handle_ = libusb_open_device_with_vid_pid(context_, table.vendor, table.product);
    if (handle_ == nullptr || !TakeInterface(table)) {
      Close();
      return false;
    }
    endpoint_ = table.endpoint;
    is_interrupt_ = IsInterruptEndpoint(handle_, endpoint_);
    return true;
  }

  void Close() override {
    if (handle_ != nullptr) {
      if (interface_ >= 0) libusb_release_interface(handle_, interface_);
      libusb_close(handle_);
    }
    if (context_ != nullptr) libusb_exit(context_);
    handle_ = nullptr;
    context_ = nullptr;
    interface_ = -1;
  }

  UsbOutcome Control(const ControlRequest& request, int timeout_ms) override {
    if (handle_ == nullptr) return UsbOutcome::kGone;
    // Three fields of one byte, which libusb declares as three types.
    constexpr auto kType = static_cast<std::uint8_t>(static_cast<unsigned>(LIBUSB_ENDPOINT_OUT) |
                                                     static_cast<unsigned>(LIBUSB_REQUEST_TYPE_VENDOR) |
                                                     static_cast<unsigned>(LIBUSB_RECIPIENT_DEVICE));
    return OutcomeOf(libusb_control_transfer(handle_, kType, request.request, request.value, request.index, nullptr, 0,
                                             static_cast<unsigned>(timeout_ms)));
  }

  UsbOutcome Write(std::span<const std::uint8_t> bytes, int timeout_ms) override {
    if (handle_ == nullptr) return UsbOutcome::kGone;
    std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());  // libusb does not promise to leave it unchanged
    int taken = 0;
    const auto transfer = is_interrupt_ ? libusb_interrupt_transfer : libusb_bulk_transfer;
    const int error = transfer(handle_, endpoint_, copy.data(), static_cast<int>(copy.size()), &taken,
                               static_cast<unsigned>(timeout_ms));
    if (error == 0 && taken != static_cast<int>(copy.size())) return UsbOutcome::kFailed;
    return OutcomeOf(error);
  }

  void ClearStall() override {
    if (handle_ != nullptr) libusb_clear_halt(handle_, endpoint_);
  }
  [[nodiscard]] bool is_simulated() const override { return false; }

 private:
  bool TakeInterface(const UsbTable& table) {
    libusb_set_auto_detach_kernel_driver(handle_, 1);
    if (libusb_claim_interface(handle_, table.interface) != 0) return false;
    interface_ = table.interface;
    return true;
  }

  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  int interface_ = -1;
  std::uint8_t endpoint_ = 0;
  bool is_interrupt_ = true;
};

}  // namespace

std::unique_ptr<UsbTransport> MakeLibusbTransport() {
  return std::make_unique<LibusbTransport>();
}

}  // namespace tactile
