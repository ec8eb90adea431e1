#pragma once

#include <string>
#include <vector>

#include "tools/bench/report.hpp"

namespace failures {

using bench::Chart;
using bench::ChartPoint;
using bench::Panel;
using bench::Report;
using bench::Series;
using bench::Short;
using bench::Table;

// What one contender did, in words and numbers.
struct Reading {
  std::string contender;  // name of a variant or of a peer
  std::string measured;
  bool is_met = false;
};

// One line of the failure tests; a failure F1 to F23 may have several.
struct Row {
  std::string id;
  std::string failure;
  std::string set_up;
  std::string observable;
  std::string bound;
  std::vector<Reading> readings;  // empty: not measured, and `why` says why
  std::string why;                // of a miss
};

// Appends to the report's table "rows" and to its goals, and prints the row. The last variant decides.
void AddRow(Report* report, const Row& row);

// Of the failures F1 to F23 in the table "rows": how many were measured, and how many have all their rows within the
// bounds. Adds this as a goal.
void AddSummary(Report* report);

}  // namespace failures
