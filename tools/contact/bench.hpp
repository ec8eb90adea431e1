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
  std::string only;  // names of parts and studies, with commas; empty: all
};

// What other libraries add to the bench.
struct Peers {
  std::vector<Contender> contenders;
  std::function<void(const Places&, Report*)> study_build;  // against OpenVDB; may be empty
};

// Everything `oos bench vps` measures: prints it, writes JSON, and to the plot folder a CSV beside each SVG.
core::Result<void> RunBench(const BenchOptions& options, const Peers& peers);

// Returns an exit status.
int BenchMain(const BenchOptions& options, const Peers& peers);

}  // namespace contact
