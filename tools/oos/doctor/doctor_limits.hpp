#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/oos/doctor/doctor_finding.hpp"

namespace oos {

// Judges the time in each period for which real-time threads may use a core: kernel.sched_rt_runtime_us [us]; -1:
// always.
Finding JudgeRealTimeShare(std::int64_t runtime_us, std::int64_t period_us);

// Judges the governor, which sets the cores' frequency; empty if the kernel does not scale it.
Finding JudgeGovernor(const std::string& governor);

// Checks the settings for real-time threads that docs/howto/lab.md makes in limits.d, sysctl.d and by cpupower.
std::vector<Finding> CheckLimits();

}  // namespace oos
