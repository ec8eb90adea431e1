#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "nodes/lockstep/lockstep.hpp"
#include "scene/scenario.hpp"

namespace system_tests {

using StepNames = std::vector<std::string>;

inline const StepNames kTouchSteps{"press", "slide", "edge", "push_block"};
inline const StepNames kPegSteps{"grasp", "insert"};
inline const StepNames kModuleSteps{"cover",    "switch_off", "grasp",    "insert_handle",
                                    "pull_out", "insert_new", "switch_on"};

inline std::string Describe(const lockstep::Outcome& outcome) {
  char line[200];
  std::snprintf(line, sizeof line, "seed %llu: %s, %.1f s simulated in %.1f s, peak %.1f N, impulse balance %.1g",
                static_cast<unsigned long long>(outcome.seed), outcome.is_completed ? "completed" : "not completed",
                outcome.simulated_s, outcome.wall_s, outcome.peak_force_N, outcome.impulse_balance);
  return outcome.why.empty() ? line : line + (": " + outcome.why);
}

// Holds for every run, also for one that fails: the force on the hand is under the cap in every tick, and momentum is
// conserved. Prints the run's figures.
inline void ExpectSound(const scene::Scenario& scenario, const lockstep::Outcome& outcome) {
  std::printf("  %s, %s\n", scenario.name.c_str(), Describe(outcome).c_str());
  std::fflush(stdout);
  EXPECT_LE(outcome.peak_force_N, scenario.force_cap_N * (1.0 + 1e-12));  // the filter cuts at the cap
  EXPECT_LE(outcome.impulse_balance, 1e-9);
}

// The run completed exactly these steps, in this order.
inline void ExpectCompleted(const lockstep::Outcome& outcome, const StepNames& names) {
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
  EXPECT_TRUE(outcome.why.empty()) << outcome.why;
  EXPECT_GT(outcome.contact_cycles, 100u) << "there was no contact";
  EXPECT_GT(outcome.peak_force_N, 1.0) << "there was no force on the hand";
  ASSERT_EQ(outcome.steps.size(), names.size());
  double seconds = 0.0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const lockstep::StepOutcome& step = outcome.steps[i];
    EXPECT_EQ(step.name, names[i]);
    EXPECT_TRUE(step.is_completed) << step.name << ": " << step.why;
    EXPECT_TRUE(step.why.empty()) << step.name << ": " << step.why;
    EXPECT_GT(step.seconds, 0.0) << step.name;
    seconds += step.seconds;
  }
  EXPECT_NEAR(seconds, outcome.simulated_s, 0.05);  // nothing happens between steps
}

// The steps before `name` are complete; `name` failed, and its reason contains `word`; later steps were not reached.
// The run reports the same.
inline void ExpectFailedIn(const lockstep::Outcome& outcome, const StepNames& names, const std::string& name,
                           const std::string& word) {
  EXPECT_FALSE(outcome.is_completed) << "the broken run completed";
  EXPECT_NE(outcome.why.find(name), std::string::npos) << outcome.why;
  ASSERT_EQ(outcome.steps.size(), names.size());
  bool is_before = true;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const lockstep::StepOutcome& step = outcome.steps[i];
    EXPECT_EQ(step.name, names[i]);
    if (step.name == name) {
      is_before = false;
      EXPECT_NE(step.why.find(word), std::string::npos) << step.why;
    }
    EXPECT_EQ(step.is_completed, is_before) << step.name << ": " << step.why;
    EXPECT_EQ(step.why.empty(), is_before) << step.name << " does not say why";
  }
  EXPECT_FALSE(is_before) << "no step '" << name << "'";
}

}  // namespace system_tests
