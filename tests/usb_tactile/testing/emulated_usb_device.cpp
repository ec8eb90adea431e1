#include "tests/usb_tactile/testing/emulated_usb_device.hpp"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace usb_tactile_tests {
namespace {

constexpr const char* kNode = "/dev/bus/usb/001/004";
constexpr const char* kSysPath = "/sys/devices/usb1/1-4";

std::string Hex(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

// As udev tells it [umockdev]: the descriptors of USB 2.0, section 9.6.
std::string DeviceText() {
  const std::vector<std::uint8_t> descriptors = {
      18, 1, 0x00, 0x02, 0xff, 0,    0, 64,   0x09, 0x12, 0x01, 0x00, 0x00, 0x01, 0, 0, 0, 1,  // device 1209:0001
      9,  2, 25,   0,    1,    1,    0, 0x80, 50,  // configuration, 25 bytes
      9,  4, 0,    0,    1,    0xff, 0, 0,    0,   // interface 0, one endpoint
      7,  5, 0x01, 3,    64,   0,    1};           // 1 OUT, interrupt, 64 bytes
  return "P: /devices/usb1/1-4\nN: bus/usb/001/004\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DRIVER=usb\n"
         "E: BUSNUM=001\nE: DEVNUM=004\nE: DEVNAME=/dev/bus/usb/001/004\nE: MAJOR=189\nE: MINOR=3\n"
         "A: busnum=1\\n\nA: devnum=4\\n\nA: bConfigurationValue=1\\n\nA: speed=12\\n\n"
         "H: descriptors=" +
         Hex(descriptors) + "\n";
}

}  // namespace

struct EmulatedUsbDevice::Urb {
  UMockdevIoctlData* data = nullptr;    // usbdevfs_urb
  UMockdevIoctlData* buffer = nullptr;  // what it carries
  [[nodiscard]] usbdevfs_urb* urb() const { return reinterpret_cast<usbdevfs_urb*>(data->data); }
  ~Urb() {
    umockdev_ioctl_data_unref(buffer);
    umockdev_ioctl_data_unref(data);
  }
};

EmulatedUsbDevice::EmulatedUsbDevice() : testbed_(umockdev_testbed_new()), handler_(umockdev_ioctl_base_new()) {
  g_object_connect(handler_, "signal-after::handle-ioctl", G_CALLBACK(HandleIoctl), this, nullptr);
}

EmulatedUsbDevice::~EmulatedUsbDevice() {
  if (is_plugged_) Unplug();
  for (auto* queue : {&finished_, &swallowed_}) {
    for (Urb* urb : *queue) delete urb;
  }
  g_object_unref(testbed_);
  g_object_unref(handler_);
}

// The handler first, so that the node answers when the device is announced.
void EmulatedUsbDevice::Plug() {
  {
    const std::lock_guard lock(mutex_);
    is_plugged_ = true;
  }
  umockdev_testbed_attach_ioctl(testbed_, kNode, handler_, nullptr);
  umockdev_testbed_add_from_string(testbed_, DeviceText().c_str(), nullptr);
}

void EmulatedUsbDevice::Unplug() {
  {
    const std::lock_guard lock(mutex_);
    is_plugged_ = false;
    while (!swallowed_.empty()) FinishSwallowed(-ESHUTDOWN);
  }
  umockdev_testbed_uevent(testbed_, kSysPath, "remove");
  umockdev_testbed_remove_device(testbed_, kSysPath);
  umockdev_testbed_detach_ioctl(testbed_, kNode, nullptr);
}

void EmulatedUsbDevice::Stall() {
  const std::lock_guard lock(mutex_);
  is_stalled_ = true;
}
void EmulatedUsbDevice::Swallow(bool does) {
  const std::lock_guard lock(mutex_);
  swallows_ = does;
}
std::vector<EmulatedUsbDevice::Bytes> EmulatedUsbDevice::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}
std::vector<EmulatedUsbDevice::Bytes> EmulatedUsbDevice::setups() const {
  const std::lock_guard lock(mutex_);
  return setups_;
}
int EmulatedUsbDevice::halts_cleared() const {
  const std::lock_guard lock(mutex_);
  return halts_cleared_;
}

gboolean EmulatedUsbDevice::HandleIoctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client,
                                        EmulatedUsbDevice* self) {
  const std::lock_guard lock(self->mutex_);
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  // As the kernel: what was submitted can be reaped after the device has gone, too.
  const bool is_reaping = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
  if (!self->is_plugged_ && !is_reaping) {
    umockdev_ioctl_client_complete(client, -1, ENODEV);
    return TRUE;
  }
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      UMockdevIoctlData* data =
          umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(guint32), nullptr);
      guint32 capabilities = USBDEVFS_CAP_NO_PACKET_SIZE_LIM;
      umockdev_ioctl_data_update(data, 0, reinterpret_cast<guint8*>(&capabilities), sizeof capabilities);
      umockdev_ioctl_data_unref(data);
      umockdev_ioctl_client_complete(client, 0, 0);
      return TRUE;
    }
    case USBDEVFS_CLEAR_HALT:
      self->is_stalled_ = false;
      ++self->halts_cleared_;
      umockdev_ioctl_client_complete(client, 0, 0);
      return TRUE;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_RESET:
      umockdev_ioctl_client_complete(client, 0, 0);
      return TRUE;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:  // no driver is there to be detached
      umockdev_ioctl_client_complete(client, -1, ENODATA);
      return TRUE;
    case USBDEVFS_SUBMITURB:
      self->Submit(client);
      return TRUE;
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      self->Reap(client);
      return TRUE;
    case USBDEVFS_DISCARDURB:
      self->Discard(client);
      return TRUE;
    default:
      umockdev_ioctl_client_complete(client, -1, ENOTTY);
      return TRUE;
  }
}

void EmulatedUsbDevice::Submit(UMockdevIoctlClient* client) {
  auto* urb = new Urb;
  urb->data = umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_urb), nullptr);
  const auto length = static_cast<std::size_t>(urb->urb()->buffer_length);
  urb->buffer = umockdev_ioctl_data_resolve(urb->data, G_STRUCT_OFFSET(usbdevfs_urb, buffer), length, nullptr);
  TakeFrame(urb);
  umockdev_ioctl_client_complete(client, 0, 0);
}

void EmulatedUsbDevice::TakeFrame(Urb* urb) {
  if (swallows_) {
    swallowed_.push_back(urb);
    return;
  }
  usbdevfs_urb& kernel = *urb->urb();
  const Bytes bytes(urb->buffer->data, urb->buffer->data + kernel.buffer_length);
  const bool is_control = kernel.type == USBDEVFS_URB_TYPE_CONTROL;
  kernel.status = !is_control && is_stalled_ ? -EPIPE : 0;
  kernel.actual_length = is_control ? kernel.buffer_length - 8 : kernel.buffer_length;
  if (kernel.status != 0) kernel.actual_length = 0;
  if (kernel.status == 0) (is_control ? setups_ : frames_).push_back(bytes);
  finished_.push_back(urb);
}

void EmulatedUsbDevice::Reap(UMockdevIoctlClient* client) {
  if (finished_.empty()) {
    umockdev_ioctl_client_complete(client, -1, is_plugged_ ? EAGAIN : ENODEV);
    return;
  }
  Urb* urb = finished_.front();
  finished_.pop_front();
  UMockdevIoctlData* to = umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(void*), nullptr);
  umockdev_ioctl_data_set_ptr(to, 0, urb->data);
  umockdev_ioctl_data_unref(to);
  umockdev_ioctl_client_complete(client, 0, 0);
  delete urb;
}

void EmulatedUsbDevice::FinishSwallowed(int status) {
  Urb* urb = swallowed_.front();
  swallowed_.pop_front();
  urb->urb()->status = status;
  urb->urb()->actual_length = 0;
  finished_.push_back(urb);
}

// libusb gives up after its time-out.
void EmulatedUsbDevice::Discard(UMockdevIoctlClient* client) {
  if (swallowed_.empty()) {
    umockdev_ioctl_client_complete(client, -1, EINVAL);
    return;
  }
  FinishSwallowed(-ENOENT);
  umockdev_ioctl_client_complete(client, 0, 0);
}

}  // namespace usb_tactile_tests
