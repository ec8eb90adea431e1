#pragma once

#include <algorithm>
#include <cstring>
#include <string_view>

#include "device/plugin.h"

namespace device {

// Writes a sentence into setting.why, cut to its size.
inline void SayWhy(const oos_device_setting& setting, std::string_view text) {
  if (setting.why == nullptr || setting.why_size == 0) return;
  const std::size_t size = std::min<std::size_t>(text.size(), setting.why_size - 1);
  std::memcpy(setting.why, text.data(), size);
  setting.why[size] = 0;
}

}  // namespace device
