#pragma once

#include <functional>
#include <vector>

#include "tools/bench/run_studies.hpp"
#include "tools/dynamics/spinner.hpp"
#include "tools/dynamics/stack.hpp"

namespace dynamics {

// What other libraries add to the bench.
struct Peers {
  std::vector<SpinnerMaker> spinners;
  std::vector<StackMaker> stacks;
  // Worst joint acceleration of ours against theirs, relative, over 1,000 random states of 7-joint arms; may be empty.
  std::function<double()> arm_error;
};

// Everything `oos bench physics` measures, see bench::RunStudies.
int BenchMain(const bench::BenchOptions& options, const Peers& peers);

}  // namespace dynamics
