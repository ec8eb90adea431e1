#pragma once

#include <cstdint>
#include <string>

namespace tactile {

struct HostileOutcome {
  std::uint64_t pulses = 0;  // that came through
  std::uint64_t stops = 0;   // jumps and open electrodes
  std::string first_wrong;   // the first pulse over a limit, and which; empty: none
};

// So many commands, calibrations, impedances, arms and disarms against a Limiter, most of them hostile, judged by an
// oracle that knows what skin and electrodes bear, and nothing of how the limiter works.
HostileOutcome RunHostileStimulation(std::uint64_t num_calls, std::uint64_t seed);

}  // namespace tactile
