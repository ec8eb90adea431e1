#include "nodes/device_bridge/devices/plugin_table.hpp"

#include <dlfcn.h>

#include <cstddef>

#include "device/builtin.hpp"
#include "hug/plugin.hpp"
#include "nodes/device_bridge/arms/arm_plugin.hpp"
#include "nodes/device_bridge/arms/simulated_hand.hpp"
#include "nodes/device_bridge/devices/replay_plugin.hpp"
#include "tracking/plugin.hpp"

namespace device_bridge {
namespace {

core::Result<PluginTable> LoadLibrary(const std::string& path) {
  if (path.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "a plug-in without address; write the path of its library");
  }
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return core::Fail(core::ErrorCode::kIo, std::string("plug-in cannot be loaded: ") + dlerror() +
                                                "; give its absolute path, and compile it with -shared -fPIC");
  }
  PluginTable table{std::shared_ptr<void>(library, [](void* open) { dlclose(open); }), nullptr};
  const auto function = reinterpret_cast<oos_device_plugin_function>(dlsym(library, OOS_DEVICE_PLUGIN_SYMBOL));
  table.functions = function != nullptr ? function() : nullptr;
  if (table.functions == nullptr) {
    return core::Fail(core::ErrorCode::kUnsupported, path + ": is no device: it does not export " +
                                                         OOS_DEVICE_PLUGIN_SYMBOL + "(), see device/plugin.h");
  }
  return table;
}

core::Result<void> CheckTable(const oos_device_plugin& table, const std::string& name) {
  if (table.abi_version != OOS_DEVICE_ABI_VERSION || table.size < offsetof(oos_device_plugin, joints)) {
    return core::Fail(core::ErrorCode::kUnsupported, name + ": has version " + std::to_string(table.abi_version) +
                                                         " of the device interface, this is " +
                                                         std::to_string(OOS_DEVICE_ABI_VERSION) +
                                                         "; compile it again with the device/plugin.h of here");
  }
  if (table.open == nullptr || table.describe == nullptr || table.step == nullptr || table.close == nullptr) {
    return core::Fail(core::ErrorCode::kUnsupported, name + ": lacks open, describe, step or close");
  }
  return {};
}

}  // namespace

core::Result<PluginTable> FindPlugin(const std::string& type, const std::string& address) {
  PluginTable table;
  if (type == "simulated_arm") table.functions = &SimulatedArmPlugin();
  if (type == "simulated_hug") table.functions = &SimulatedHugPlugin();
  if (type == "simulated_hand") table.functions = &SimulatedHandPlugin();
  if (type == "hug") table.functions = &hug::Plugin();
  if (type == "udp") table.functions = &device::UdpPlugin();
  if (type == "serial") table.functions = &device::SerialPlugin();
  if (type == "haply") table.functions = &device::HaplyPlugin();
  if (type == "dtrack") table.functions = &tracking::Plugin();
  if (type == "replay") table.functions = &ReplayPlugin();
  if (type == "plugin") {
    auto loaded = LoadLibrary(address);
    if (!loaded) return loaded;
    table = std::move(*loaded);
  }
  if (table.functions == nullptr) {
    return core::Fail(core::ErrorCode::kUnsupported,
                      "unknown type '" + type +
                          "'. Fix: type=\"simulated_arm\", \"simulated_hug\", \"simulated_hand\", \"hug\", \"udp\", "
                          "\"serial\", \"plugin\", "
                          "\"haply\", \"dtrack\" or \"replay\".");
  }
  if (auto checked = CheckTable(*table.functions, type == "plugin" ? address : type); !checked) {
    return tl::unexpected(checked.error());
  }
  return table;
}

DeviceSetting::DeviceSetting(const scene::Device& device)
    : role_(device.role), address_(device.address), texts_(device.options) {
  for (auto& option : ArmOptions(device)) texts_.push_back(std::move(option));
  for (const auto& [name, value] : texts_) options_.push_back({name.c_str(), value.c_str()});
}

oos_device_setting DeviceSetting::View(char* why, std::uint32_t why_size) const {
  oos_device_setting setting{};
  setting.size = sizeof setting;
  setting.num_options = static_cast<std::uint32_t>(options_.size());
  setting.role = role_.c_str();
  setting.address = address_.c_str();
  setting.options = options_.data();
  setting.why = why;
  setting.why_size = why_size;
  if (why_size > 0) why[0] = 0;
  return setting;
}

}  // namespace device_bridge
