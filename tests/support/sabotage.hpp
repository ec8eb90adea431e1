#pragma once

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"

namespace system_tests {

// An operator that gets nowhere is given up earlier than in a run for people; no step that works takes longer.
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
