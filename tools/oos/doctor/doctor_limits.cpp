#include "tools/oos/doctor/doctor_limits.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace oos {
namespace {

constexpr int kWantedPriority = 85;  // of device-rt, the highest of all nodes
constexpr int kWantedNice = -5;      // of the threads that serve the bus and write recordings

Finding CheckRealTimePriority() {
  // Sets the priority and resets it at once: the limits alone do not show whether a container allows it.
  sched_param before{}, wanted{};
  const int policy_before = sched_getscheduler(0);
  sched_getparam(0, &before);
  wanted.sched_priority = kWantedPriority;
  const std::string priority = "real-time priority (SCHED_FIFO " + std::to_string(kWantedPriority) + ")";
  if (sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) {
    sched_setscheduler(0, policy_before, &before);
    return {"realtime", Grade::kOk, priority + " is allowed", ""};
  }
  return {"realtime", Grade::kWarn, "no " + priority + ": " + std::strerror(errno),
          "add '@realtime - rtprio 95' to /etc/security/limits.d/realtime.conf and join that group; in a container: "
          "--cap-add SYS_NICE"};
}

Finding CheckMemoryLock() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  constexpr rlim_t kEnough = 512UL << 20;
  if (geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= kEnough) {
    return {"memlock", Grade::kOk, "memory can be locked", ""};
  }
  return {"memlock", Grade::kWarn,
          "only " + std::to_string(limit.rlim_cur >> 10) + " kB can be locked: page faults cost cycles",
          "add '@realtime - memlock unlimited' to /etc/security/limits.d/realtime.conf"};
}

Finding CheckNice() {
  const int before = getpriority(PRIO_PROCESS, 0);
  if (before > kWantedNice) {  // set and reset, as above
    if (setpriority(PRIO_PROCESS, 0, kWantedNice) != 0) {
      return {"nice", Grade::kWarn,
              "threads of the bus cannot take precedence (nice " + std::to_string(kWantedNice) +
                  "): " + std::strerror(errno),
              "add '@realtime - nice -10' to /etc/security/limits.d/realtime.conf and join that group; in a container: "
              "--cap-add SYS_NICE"};
    }
    setpriority(PRIO_PROCESS, 0, before);
  }
  return {"nice", Grade::kOk, "threads of the bus can take precedence (nice " + std::to_string(kWantedNice) + ")", ""};
}

Finding CheckRealTimeShare() {
  std::int64_t runtime_us = -1, period_us = 1'000'000;
  std::ifstream("/proc/sys/kernel/sched_rt_runtime_us") >> runtime_us;
  std::ifstream("/proc/sys/kernel/sched_rt_period_us") >> period_us;
  return JudgeRealTimeShare(runtime_us, period_us);
}

Finding CheckGovernor() {
  std::string governor;
  std::ifstream("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor") >> governor;
  return JudgeGovernor(governor);
}

}  // namespace

Finding JudgeRealTimeShare(std::int64_t runtime_us, std::int64_t period_us) {
  if (runtime_us < 0 || runtime_us >= period_us) {
    return {"realtime_share", Grade::kOk, "real-time threads are never held back", ""};
  }
  return {"realtime_share", Grade::kWarn,
          "the kernel holds busy real-time threads back for " + std::to_string((period_us - runtime_us) / 1000) +
              " ms of every " + std::to_string(period_us / 1000) + " ms",
          "add 'kernel.sched_rt_runtime_us = -1' to /etc/sysctl.d/50-realtime.conf, then sysctl --system"};
}

Finding JudgeGovernor(const std::string& governor) {
  if (governor.empty()) return {"governor", Grade::kOk, "no scaling of the cores' speed", ""};
  if (governor == "performance") return {"governor", Grade::kOk, "cores keep their speed", ""};
  return {"governor", Grade::kWarn, "cores change their speed (" + governor + "): cycles come late after idling",
          "cpupower frequency-set -g performance, of the package linux-cpupower"};
}

std::vector<Finding> CheckLimits() {
  return {CheckRealTimePriority(), CheckMemoryLock(), CheckNice(), CheckRealTimeShare(), CheckGovernor()};
}

}  // namespace oos
