#include "bus/membership/machine_id.hpp"

#include <cstdlib>
#include <fstream>

namespace bus::detail {

std::string MachineId() {
  if (const char* id = std::getenv("OOS_MACHINE_ID"); id != nullptr && *id != '\0') return id;
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  file >> id;
  return id;
}

}  // namespace bus::detail
