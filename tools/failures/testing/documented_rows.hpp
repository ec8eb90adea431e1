#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace failures {

// "yes", "no" or "not measured" for each row of a rows.csv, which is named by its failure, set-up and observable.
using Verdicts = std::map<std::string, std::string>;

// Of CSV text with the columns that AddRow writes.
Verdicts ParseVerdicts(const std::string& csv);
Verdicts ReadVerdicts(const std::filesystem::path& file);
// Those that docs/performance/stability.md shows, in the source tree at `root`.
Verdicts DocumentedVerdicts(const std::filesystem::path& root);

// A line for each measured row that the document does not have, or of which it says otherwise.
std::vector<std::string> Contradictions(const Verdicts& measured, const Verdicts& documented);

}  // namespace failures
