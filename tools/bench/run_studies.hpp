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
// The studies that `only` names, with commas between them; an unknown name is an error that lists the known ones.
core::Result<std::vector<std::string>> ReadNames(const std::string& text, const std::vector<std::string>& known);
// Makes the plot folder unless `plot` is empty.
core::Result<void> MakePlotFolder(const std::filesystem::path& plot);

// Runs the selected studies, prints their results, and writes the JSON file and the plot folder (Write in report.hpp).
// Returns an exit status. `missing_peer`: the library that is not part of this program; empty: none.
int RunStudies(const BenchOptions& options, const Heading& heading, const std::vector<Study>& studies,
               const std::string& missing_peer);

}  // namespace bench
