#include "tools/oos/doctor/doctor_devices.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace oos {
namespace {

constexpr std::array kKinds = {"ttyACM", "ttyUSB", "hidraw"};

}  // namespace

Finding CheckDeviceFiles(const std::filesystem::path& folder) {
  std::vector<std::string> closed;
  int num_open = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool is_ours =
        std::any_of(kKinds.begin(), kKinds.end(), [&](const char* kind) { return name.starts_with(kind); });
    if (!is_ours) continue;
    if (access(entry.path().c_str(), R_OK | W_OK) == 0) {
      ++num_open;
    } else {
      closed.push_back(entry.path().string());
    }
  }
  if (closed.empty()) {
    return {"devices", Grade::kOk,
            num_open == 0 ? "no serial line or USB input device is plugged in; UDP and simulated devices need none"
                          : std::to_string(num_open) + " serial lines and USB input devices can be opened",
            ""};
  }
  std::sort(closed.begin(), closed.end());
  std::string names;
  for (const std::string& name : closed) names += (names.empty() ? "" : ", ") + name;
  return {"devices", Grade::kWarn, "hand devices that this user may not open: " + names,
          "write SUBSYSTEM==\"tty\", KERNEL==\"ttyACM*|ttyUSB*\", TAG+=\"uaccess\" and SUBSYSTEM==\"hidraw\", "
          "TAG+=\"uaccess\" as two lines into /etc/udev/rules.d/70-vr-oos-devices.rules, then 'udevadm control "
          "--reload' and "
          "'udevadm trigger'; over ssh, join the group dialout"};
}

}  // namespace oos
