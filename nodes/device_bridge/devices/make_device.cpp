#include "nodes/device_bridge/devices/make_device.hpp"

#include <algorithm>

#include "core/names.hpp"
#include "device/calibration.hpp"
#include "nodes/device_bridge/devices/immediate_device.hpp"

namespace device_bridge {
namespace {

// Types whose tables are called at once.
bool IsImmediate(const std::string& type) {
  return type == "simulated_arm" || type == "simulated_hug" || type == "simulated_hand" || type == "hug";
}

std::string Title(const scene::Device& device) {
  const std::string where = device.location.file.empty()
                                ? ""
                                : device.location.file.string() + ":" + std::to_string(device.location.line) + ": ";
  return where + "device '" + device.role + "': ";
}

}  // namespace

core::Result<std::unique_ptr<Device>> MakeDevice(const scene::Device& device,
                                                 const std::optional<ThreadedOptions>& threads) {
  auto plugin = FindPlugin(device.type, device.address);
  if (!plugin) return core::Fail(plugin.error().code, Title(device) + plugin.error().detail);
  if (IsImmediate(device.type)) {
    auto made = ImmediateDevice::Create(std::move(*plugin), device);
    if (!made) return core::Fail(made.error().code, Title(device) + made.error().detail);
    return std::unique_ptr<Device>(std::move(*made));
  }
  if (!threads) {
    return core::Fail(core::ErrorCode::kUnsupported,
                      Title(device) + "type " + device.type +
                          " lives in real time, and lock-step has time of its own. Fix: run it without --lockstep.");
  }
  auto made = ThreadedDevice::Create(std::move(*plugin), device, *threads);
  if (!made) return core::Fail(made.error().code, Title(device) + made.error().detail);
  return std::unique_ptr<Device>(std::move(*made));
}

std::optional<DeviceCalibration> KeptCalibration(const std::string& name, const std::string& serial) {
  std::string why;
  const auto kept = device::FindCalibration(device::CalibrationFolder(), name, serial, &why);
  if (!kept) return std::nullopt;
  return DeviceCalibration{kept->X_WB, kept->residual_m};
}

core::Result<scene::Device> DeviceNamed(const std::string& text) {
  scene::Device device;
  const std::size_t colon = std::min(text.find(':'), text.size());
  device.type = text.substr(0, colon);
  device.address = text.substr(std::min(colon + 1, text.size()));
  const std::vector<std::string> types(std::begin(scene::kDeviceTypes), std::end(scene::kDeviceTypes));
  if (std::find(types.begin(), types.end(), device.type) == types.end()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "'" + text + "': no device has the type '" + device.type + "'; " +
                                                          core::SuggestName(device.type, types));
  }
  if (IsImmediate(device.type) != device.address.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "'" + text + "': " +
                          (IsImmediate(device.type) ? "a simulated device has no address"
                                                    : "write where it is, as udp:7460, "
                                                      "serial:/dev/ttyUSB0, plugin:/path/of/lib.so or "
                                                      "replay:run.mcap"));
  }
  return device;
}

namespace {

core::Result<void> ChooseTactile(const std::string& type, scene::Tactile* tactile) {
  if (type != "simulated" && type != "usb") {
    return core::Fail(core::ErrorCode::kInvalidInput, "--device '" + tactile->name + "=" + type +
                                                          "': a tactile device is simulated or usb, as its file says");
  }
  tactile->type = type;
  return {};
}

}  // namespace

core::Result<void> ChooseDevices(const std::vector<std::string>& texts, scene::Scenario* scenario) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "--device '" + text + "': write ROLE=TYPE:ADDRESS, as right=udp:7460");
    }
    const std::string role = text.substr(0, equals);
    if (const int tactile = scenario->FindTactile(role); tactile >= 0) {
      const auto chosen =
          ChooseTactile(text.substr(equals + 1), &scenario->tactiles[static_cast<std::size_t>(tactile)]);
      if (!chosen) return chosen;
      continue;
    }
    const int index = scenario->FindRole(role);
    if (index < 0) {
      std::vector<std::string> roles;
      for (const scene::Device& device : scenario->devices) roles.push_back(device.role);
      for (const scene::Tactile& tactile : scenario->tactiles) roles.push_back(tactile.name);
      return core::Fail(core::ErrorCode::kInvalidInput, "--device '" + text + "': scenario " + scenario->name +
                                                            " has no role '" + role + "'; " +
                                                            core::SuggestName(role, roles));
    }
    const auto named = DeviceNamed(text.substr(equals + 1));
    if (!named) return core::Fail(named.error().code, "--device " + named.error().detail);
    scene::Device& device = scenario->devices[static_cast<std::size_t>(index)];
    device.type = named->type;
    device.address = named->address;
  }
  return {};
}

}  // namespace device_bridge
