#include "core/clock.hpp"

#include <cstdio>
#include <string>

#include "tools/oos/launch/verbs.hpp"

namespace oos {
namespace {

// Answers each line with this machine's CLOCK_MONOTONIC at the time of reading it [ns].
int RunClock(const Arguments&) {
  for (int c = std::getchar(); c != EOF; c = std::getchar()) {
    if (c != '\n') continue;
    std::printf("%lld\n", static_cast<long long>(core::MonotonicNow_ns()));
    std::fflush(stdout);
  }
  return kHolds;
}

}  // namespace

Verb ClockVerb() {
  return {"clock", "answers each line of stdin with this machine's CLOCK_MONOTONIC in ns; used by 'oos launch'",
          "",      0,
          0,       {},
          RunClock};
}

}  // namespace oos
