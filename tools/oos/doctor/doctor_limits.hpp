#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/oos/doctor/doctor_finding.hpp"

namespace oos {

// Of every period, how long real-time threads may have a core: kernel.sched_rt_runtime_us; -1: always.
Finding JudgeRealTimeShare(std::int64_t runtime_us, std::int64_t period_us);

// How the cores' speed is chosen; empty: the kernel does not choose it.
Finding JudgeGovernor(const std::string& governor);

// What docs/howto/lab.md sets in limits.d, sysctl.d and by cpupower for the threads that keep time, a finding a line.
std::vector<Finding> CheckLimits();

}  // namespace oos
