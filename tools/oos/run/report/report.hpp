#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scene/scenario.hpp"

namespace oos {

// Facts of a run (processes or lock-step) that are not in the nodes' own files.
struct RunFacts {
  bool is_completed = false;
  std::string why;  // when not
  std::uint64_t seed = 0;
  double seconds = 0.0;
  std::vector<std::string> dead;
  bool is_lockstep = false;
  std::vector<std::string> missing_nodes;  // left out on purpose
};

// Merges the nodes' reports in `folder` (<node>.json) and the facts into one report. Units are in the field names. A
// figure that no node reported is null.
nlohmann::json MergeReport(const scene::Scenario& scenario, const RunFacts& facts, const std::filesystem::path& folder);

// Writes report.json, report.md and report.html. False when the folder cannot be written.
bool WriteReport(const nlohmann::json& report, const std::filesystem::path& folder);

// A summary of the report for the terminal: steps and the main figures.
std::string Summarise(const nlohmann::json& report);

// The reports of several methods for one scenario as a table with a column for each, in Markdown.
std::string CompareMethods(const std::vector<nlohmann::json>& reports);
// Writes it to report.md, and the reports by method to report.json. False when the folder cannot be written.
bool WriteComparison(const std::vector<nlohmann::json>& reports, const std::filesystem::path& folder);

}  // namespace oos
