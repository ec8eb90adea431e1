#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/contact/method.hpp"
#include "tools/contact/workload.hpp"

namespace contact {

// A method at one resolution, as it takes part in the comparison.
struct Contender {
  std::string method;   // a series of the charts
  std::string setting;  // a point of the series
  std::function<core::Result<std::unique_ptr<Method>>(const Workload&)> make;
  bool has_magnitude = true;  // its force is the depth integral; else only its direction means something
  bool has_wrench = true;
};

// One contender on one workload. Errors are against the oracle, medians and worst over the poses.
struct Measurement {
  std::string workload, method, setting;
  double time_p50_us = 0.0, time_p99_us = 0.0, time_max_us = 0.0;
  double times_paper = 0.0;  // time_p50 over that of `paper` at the middle resolution, same run
  double build_s = 0.0;
  // Below 0: the method does not say.
  double direction_deg = -1.0, direction_worst_deg = -1.0;
  double magnitude_error = -1.0, magnitude_worst = -1.0;  // | |F| / |F_ref| - 1 |
  double torque_error = -1.0, torque_worst = -1.0;        // |M - M_ref| / (|F_ref| times B's radius)
  double depth_error_m = -1.0, depth_worst_m = -1.0;
  double missed = 0.0;  // fraction of the poses at which no contact was reported
};

struct BenchOptions {
  std::filesystem::path json;  // empty: none
  std::filesystem::path plot;  // folder; empty: none
  std::filesystem::path meshes;
  std::filesystem::path scenarios;
  std::string only;  // name of one pair; empty: all
};

// `paper` and `fast` at several voxel sizes and point counts.
std::vector<Contender> OwnContenders();

// Runs all on all workloads, prints a table, writes JSON, and for each workload a CSV and an SVG. Repetitions of the
// contenders alternate, so that a change of the machine's speed meets all of them; each turn of a quick one begins with
// a pass that does not count, since the others have cleared the caches.
core::Result<void> RunBench(const BenchOptions& options, const std::vector<Contender>& contenders);

// Takes --json F, --plot DIR, --meshes DIR as the verb does. Returns an exit status.
int BenchMain(const BenchOptions& options, const std::vector<Contender>& contenders);

}  // namespace contact
