#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "collision/resolution/choose_resolutions.hpp"
#include "nodes/lockstep/lockstep.hpp"

namespace system_tests {

// The scenario of that name in scenarios/; a test that cannot read it has failed.
inline scene::Scenario Load(const std::string& name) {
  const auto scenario = collision::LoadResolvedScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
  if (!scenario) {
    ADD_FAILURE() << scene::Format(scenario.error().front());
    return {};
  }
  return *scenario;
}

// The same with the paper's method and coupling, in place of the scenario's.
inline scene::Scenario LoadPaper(const std::string& name) {
  scene::Scenario scenario = Load(name);
  scenario.method = "paper";
  scenario.coupling.type = "paper";
  return scenario;
}

inline lockstep::Outcome InLockstep(const scene::Scenario& scenario, const lockstep::Options& options = {}) {
  const auto outcome = lockstep::Run(scenario, options);
  if (!outcome) {
    ADD_FAILURE() << outcome.error().detail;
    return {};
  }
  return *outcome;
}

// Index of the pair of these two objects, in either order.
inline std::size_t PairOf(const scene::Scenario& scenario, const std::string& a, const std::string& b) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const std::string name = scenario.PairName(i);
    if (name == a + "/" + b || name == b + "/" + a) return i;
  }
  ADD_FAILURE() << "no pair " << a << "/" << b;
  return 0;
}

}  // namespace system_tests
