#pragma once

#include <memory>
#include <optional>

#include "core/result.hpp"
#include "nodes/device_bridge/device.hpp"
#include "nodes/device_bridge/devices/threaded_device.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// The device of a role, by its type. `threads`: none means that only devices of virtual time are possible (lock-step).
core::Result<std::unique_ptr<Device>> MakeDevice(const scene::Device& device,
                                                 const std::optional<ThreadedOptions>& threads);

// The calibration of a specimen that `oos device calibrate` has kept.
std::optional<DeviceCalibration> KeptCalibration(const std::string& name, const std::string& serial);

// Changes the devices of a scenario by texts ROLE=TYPE or ROLE=TYPE:ADDRESS, as "right=udp:7460"; of a tactile device
// NAME=simulated or NAME=usb. Error: what is wrong with one of them.
core::Result<void> ChooseDevices(const std::vector<std::string>& texts, scene::Scenario* scenario);
// TYPE or TYPE:ADDRESS.
core::Result<scene::Device> DeviceNamed(const std::string& text);

}  // namespace device_bridge
