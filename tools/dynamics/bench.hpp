#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/report.hpp"
#include "tools/dynamics/spinner.hpp"
#include "tools/dynamics/stack.hpp"

namespace dynamics {

struct BenchOptions {
  std::filesystem::path json;  // empty: none
  std::filesystem::path plot;  // folder; empty: none
  std::string only;            // names of studies, with commas; empty: all
};

// What other libraries add to the bench.
struct Peers {
  std::vector<SpinnerMaker> spinners;
  std::vector<StackMaker> stacks;
  // Worst joint acceleration of ours against theirs, relative, over 1,000 random states of 7-joint arms; may be empty.
  std::function<double()> arm_error;
};

// Everything `oos bench physics` measures: prints it, writes JSON, and to the plot folder a CSV beside each SVG.
// Returns an exit status.
int BenchMain(const BenchOptions& options, const Peers& peers);

}  // namespace dynamics
