#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/report.hpp"

namespace bench {

struct BenchOptions {
  std::filesystem::path json;  // empty: none
  std::filesystem::path plot;  // folder; empty: none
  std::string only;            // names of studies, with commas; empty: all
};

struct Study {
  std::string name;
  std::function<void(Report*)> run;
};

std::vector<std::string> SplitAtCommas(const std::string& text);
// Names with commas; one that is not among the known is an error that lists them.
core::Result<std::vector<std::string>> ReadNames(const std::string& text, const std::vector<std::string>& known);
// Makes the plot folder if there is to be one.
core::Result<void> MakePlotFolder(const std::filesystem::path& plot);

// Runs the studies that are asked for, prints what they find, writes JSON, and to the plot folder a CSV beside each SVG
// and the goals. Returns an exit status. `missing_peer`: the library that is not part of this program; empty: none.
int RunStudies(const BenchOptions& options, const Heading& heading, const std::vector<Study>& studies,
               const std::string& missing_peer);

}  // namespace bench
