#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "device/plugin.h"
#include "scene/scenario.hpp"

namespace device_bridge {

// The functions of a device, and the shared library that they are in.
struct PluginTable {
  std::shared_ptr<void> library;  // null: compiled in
  const oos_device_plugin* functions = nullptr;
};

// Whether the device is a robot: a table that is older ends before `joints`.
inline bool GivesJoints(const PluginTable& plugin) {
  return plugin.functions->size > offsetof(oos_device_plugin, joints) && plugin.functions->joints != nullptr;
}

// Whether it has a function to lead the hand.
inline bool CanLead(const PluginTable& plugin) {
  return plugin.functions->size > offsetof(oos_device_plugin, lead) && plugin.functions->lead != nullptr;
}

// Of a device type of the scenario. For type "plugin" the library `address` is loaded. Errors: kUnsupported for another
// type or ABI version, kIo for a library that cannot be loaded.
core::Result<PluginTable> FindPlugin(const std::string& type, const std::string& address);

// What a plug-in gets to open: texts with their storage.
class DeviceSetting {
 public:
  explicit DeviceSetting(const scene::Device& device);
  // The pointers stay valid as long as this object. `why` receives the plug-in's reason.
  [[nodiscard]] oos_device_setting View(char* why, std::uint32_t why_size) const;

 private:
  std::string role_, address_;
  std::vector<std::pair<std::string, std::string>> texts_;
  std::vector<oos_device_option> options_;
};

}  // namespace device_bridge
