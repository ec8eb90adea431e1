#pragma once

#include "tools/bench/report.hpp"

namespace contact {

using bench::Bar;
using bench::Cell;
using bench::Chart;
using bench::ChartPoint;
using bench::Goal;
using bench::Panel;
using bench::Report;
using bench::Series;
using bench::Short;
using bench::Table;
using bench::Verdict;

}  // namespace contact
