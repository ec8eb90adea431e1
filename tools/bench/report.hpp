#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "tools/bench/chart.hpp"
#include "tools/bench/table.hpp"

namespace bench {

enum class Verdict { kMet, kPartly, kMissed, kNotMeasured };

// A requirement on a measured figure, and whether it is met.
struct Goal {
  std::string what;
  std::string wanted;
  std::string measured;
  Verdict verdict = Verdict::kNotMeasured;
};

struct Report {
  std::vector<Goal> goals;
  std::vector<Table> tables;
  std::vector<std::pair<std::string, Chart>> charts;  // by file name
  std::vector<std::string> skipped;                   // each with its reason

  void AddGoal(std::string what, std::string wanted, std::string measured, bool is_met) {
    goals.push_back(
        {std::move(what), std::move(wanted), std::move(measured), is_met ? Verdict::kMet : Verdict::kMissed});
  }
};

// The head of a report.
struct Heading {
  std::string bench;    // as in `oos bench NAME`
  std::string title;    // of the page of goals
  std::string machine;  // see ProcessorText
};

const char* ToText(Verdict verdict);
Table GoalTable(const std::vector<Goal>& goals);
// Names the processor and the compiler.
std::string ProcessorText();
void PrintGoals(const std::vector<Goal>& goals);
// Writes into the plot folder a CSV of every table, an SVG of every chart and the goals as goals.md; into the JSON file
// all tables. An empty path writes nothing.
core::Result<void> WriteReport(const std::filesystem::path& json, const std::filesystem::path& plot,
                               const Heading& heading, const Report& report);

}  // namespace bench
