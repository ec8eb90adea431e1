#include "core/clock.hpp"

#include <cstdio>
#include <string>

#include "tools/oos/launch/verbs.hpp"

namespace oos {
namespace {

// An answer to each line: this machine's CLOCK_MONOTONIC when the line was read.
int Run(const Arguments&) {
  for (int c = std::getchar(); c != EOF; c = std::getchar()) {
    if (c != '\n') continue;
    std::printf("%lld\n", static_cast<long long>(core::MonotonicNow_ns()));
    std::fflush(stdout);
  }
  return kHolds;
}

}  // namespace

Verb ClockVerb() {
  return {"clock", "answers each line of stdin with this machine's CLOCK_MONOTONIC in ns; 'oos launch' asks it",
          "",      0,
          0,       {},
          Run};
}

}  // namespace oos
