#pragma once

#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "tools/bench/table.hpp"
#include "tools/oos/sweep/sweep_plan.hpp"

namespace oos {

// The result in a run's report.json. An unreadable report counts as missing, and so does that of an interrupted run.
struct SweepOutcome {
  bool has_report = false;
  bool is_completed = false;
  double seconds = 0.0;  // simulated
  double peak_force_N = 0.0;
  std::string why;  // when not completed
};

SweepOutcome ReadOutcome(const std::filesystem::path& run_folder);

// One row per run.
bench::Table ResultTable(const std::vector<GridAxis>& axes, const std::vector<SweepRun>& runs,
                         const std::vector<SweepOutcome>& outcomes);

// Draws peak force, time and share of completed runs over the first axis as SVG text: means over the seeds, a line for
// each combination of the other axes' values.
std::string ResultChart(const std::string& scenario, const std::vector<GridAxis>& axes,
                        const std::vector<SweepRun>& runs, const std::vector<SweepOutcome>& outcomes);

}  // namespace oos
