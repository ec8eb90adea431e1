#pragma once

#include "device/frame_link.hpp"
#include "device/plugin.h"

namespace device {

// The table of a device that is a FrameLink over some line. D has
//   int Step(now_ns, command, state);  const FrameLink& link() const;  int fd() const;
template <class D>
oos_device_plugin PluginOf(int (*open)(const oos_device_setting*, void**)) {
  oos_device_plugin plugin{};
  plugin.abi_version = OOS_DEVICE_ABI_VERSION;
  plugin.size = sizeof plugin;
  plugin.open = open;
  plugin.describe = [](void* device, oos_device_description* description) -> int {
    const FrameLink& link = static_cast<D*>(device)->link();
    if (!link.has_description()) return OOS_DEVICE_GONE;
    *description = link.description();
    return OOS_DEVICE_OK;
  };
  plugin.step = [](void* device, std::int64_t now_ns, const oos_device_command* command,
                   const oos_device_hand* /*hand*/,
                   oos_device_state* state) -> int { return static_cast<D*>(device)->Step(now_ns, command, state); };
  plugin.close = [](void* device) { delete static_cast<D*>(device); };
  plugin.wait_fd = [](void* device) -> int { return static_cast<D*>(device)->fd(); };
  return plugin;
}

}  // namespace device
