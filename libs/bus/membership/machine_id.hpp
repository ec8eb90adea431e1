#pragma once

#include <string>

namespace bus::detail {

// Nodes with the same id share a kernel, and so CLOCK_MONOTONIC: the kernel's boot id, or the environment variable
// OOS_MACHINE_ID where namespaces of one kernel stand for several machines.
std::string MachineId();

}  // namespace bus::detail
