#include "bus/rt/thread_setup.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace bus {
namespace {

std::string Reason(int error) {
  return std::error_code(error, std::generic_category()).message();
}

}  // namespace

bool ParseRealTimeMode(const std::string& text, RealTimeMode* mode) {
  if (text == "off") {
    *mode = RealTimeMode::kOff;
  } else if (text == "try") {
    *mode = RealTimeMode::kTry;
  } else if (text == "enforce") {
    *mode = RealTimeMode::kEnforce;
  } else {
    return false;
  }
  return true;
}

ThreadReport SetUpThread(const ThreadSetup& setup) {
  ThreadReport report;
  if (!setup.name.empty()) pthread_setname_np(pthread_self(), setup.name.substr(0, 15).c_str());
  prctl(PR_SET_TIMERSLACK, 1UL);

#if defined(__SSE2__)
  constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
  _mm_setcsr(_mm_getcsr() | kFlushToZero | kDenormalsAreZero);
  report.flushes_denormals = true;
#endif

  std::string fifo = "off";
  std::string memory = "off";
  if (setup.mode != RealTimeMode::kOff) {
    sched_param parameter{};
    parameter.sched_priority = setup.fifo_priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
    report.is_fifo = error == 0;
    fifo = error == 0
               ? "FIFO " + std::to_string(setup.fifo_priority)
               : "no FIFO (" + Reason(error) + "; allow it with rtprio in /etc/security/limits.d or CAP_SYS_NICE)";
    if (setup.locks_memory) {
      report.is_memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
      memory = report.is_memory_locked ? "locked" : "not locked (" + Reason(errno) + "; raise `ulimit -l`)";
    } else {
      memory = "not requested";
    }
  }
  if (!report.is_fifo && setup.nice != 0) {
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), setup.nice);
  }
  report.is_ok =
      setup.mode != RealTimeMode::kEnforce || (report.is_fifo && (!setup.locks_memory || report.is_memory_locked));
  report.text = "thread " + setup.name + ": scheduling " + fifo + ", memory " + memory + ", denormals " +
                (report.flushes_denormals ? "flushed" : "kept");
  return report;
}

}  // namespace bus
