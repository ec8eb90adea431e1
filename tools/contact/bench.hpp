#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/contact/contest.hpp"
#include "tools/contact/report.hpp"

namespace contact {

struct BenchOptions {
  std::filesystem::path json;  // empty: none
  std::filesystem::path plot;  // folder; empty: none
  Places places;
  std::string only;  // names of parts and studies, separated by commas; empty: all
};

// Methods and studies of other libraries.
struct Peers {
  std::vector<Contender> contenders;
  std::function<void(const Places&, Report*)> study_build;  // against OpenVDB; may be empty
};

// Runs all measurements of `oos bench vps`, prints them, writes the JSON file, and a CSV beside each SVG to the plot
// folder. Errors: an unknown name in `only`, a file or folder that cannot be written.
core::Result<void> RunBench(const BenchOptions& options, const Peers& peers);

// RunBench as a program: prints an error and returns the exit status, 0 or 2.
int BenchMain(const BenchOptions& options, const Peers& peers);

}  // namespace contact
