#include "bus/rt/stolen_time.hpp"

#include <unistd.h>

#include <fstream>
#include <string>

namespace bus {

// First line of /proc/stat: "cpu", then user, nice, system, idle, iowait, irq, softirq, steal, ... in clock ticks.
double StolenTime_s() {
  std::ifstream stat("/proc/stat");
  std::string cpu;
  double ticks[8] = {};
  stat >> cpu;
  for (double& number : ticks) stat >> number;
  return stat ? ticks[7] / static_cast<double>(sysconf(_SC_CLK_TCK)) : 0.0;
}

}  // namespace bus
