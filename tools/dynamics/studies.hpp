#pragma once

#include "tools/dynamics/bench.hpp"

namespace dynamics {

using bench::Cell;
using bench::Chart;
using bench::ChartPoint;
using bench::Panel;
using bench::Report;
using bench::Series;
using bench::Short;
using bench::Table;

// Each study adds its tables, charts and goals to the report.
void StudyRotation(const Peers& peers, Report* report);
void StudyRebound(const Peers& peers, Report* report);
void StudyReduction(const Peers& peers, Report* report);
void StudyMassRatio(const Peers& peers, Report* report);
void StudyPeg(const Peers& peers, Report* report);
void StudyCloth(const Peers& peers, Report* report);
void StudyRows(const Peers& peers, Report* report);

}  // namespace dynamics
