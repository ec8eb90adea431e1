#pragma once

#include <filesystem>

#include "tools/oos/doctor/doctor_finding.hpp"

namespace oos {

// Whether this user may open the device files of hand devices in `folder` (/dev): serial lines and USB input devices.
Finding CheckDeviceFiles(const std::filesystem::path& folder);

}  // namespace oos
