#pragma once

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"

namespace system_tests {

// Simulated seconds without progress after which a run has failed: less than in a run for people, but more than any
// successful step takes.
inline constexpr double kStallLimit_s = 20.0;

inline lockstep::Outcome RunSabotaged(scene::Scenario scenario, const lockstep::Options& options = {}) {
  scenario.stall_limit_s = kStallLimit_s;
  const lockstep::Outcome outcome = InLockstep(scenario, options);
  ExpectSound(scenario, outcome);
  return outcome;
}

// The contact pairs of both jaws with an object.
inline void SwitchOffJaws(scene::Scenario* scenario, const std::string& object) {
  for (const char* jaw : {"jaw_left", "jaw_right"}) {
    scenario->pairs[PairOf(*scenario, jaw, object)].is_active = false;
  }
}

}  // namespace system_tests
