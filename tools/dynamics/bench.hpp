#pragma once

#include <functional>
#include <vector>

#include "tools/bench/run_studies.hpp"
#include "tools/dynamics/spinner.hpp"
#include "tools/dynamics/stack.hpp"

namespace dynamics {

// Measurements with other libraries, added to the bench where those are installed.
struct Peers {
  std::vector<SpinnerMaker> spinners;
  std::vector<StackMaker> stacks;
  // Largest relative difference between our joint accelerations and theirs, over 1,000 random states of 7-joint arms;
  // may be empty.
  std::function<double()> arm_error;
};

// Runs every study of `oos bench physics`, see bench::RunStudies.
int BenchMain(const bench::BenchOptions& options, const Peers& peers);

}  // namespace dynamics
