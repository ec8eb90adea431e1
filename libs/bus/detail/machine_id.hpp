#pragma once

#include <string>

namespace bus::detail {

// Nodes with the same id share a kernel and its CLOCK_MONOTONIC: the kernel's boot id, or OOS_MACHINE_ID of the
// environment, for machines that are made of namespaces of one kernel.
std::string MachineId();

}  // namespace bus::detail
