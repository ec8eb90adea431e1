#pragma once

#include "tools/transport/bench.hpp"

namespace transport {

using bench::Bar;
using bench::Cell;
using bench::Chart;
using bench::ChartPoint;
using bench::Panel;
using bench::Report;
using bench::Series;
using bench::Short;
using bench::Table;

struct Setting {
  const std::vector<Peer>& peers;
  double effort = 1.0;

  [[nodiscard]] std::int64_t Rounds(std::int64_t of_whole) const {
    return static_cast<std::int64_t>(static_cast<double>(of_whole) * effort) + 1;
  }
};

// Each adds its tables, charts and goals.
void StudyHop(const Setting& setting, Report* report);
void StudyClasses(const Setting& setting, Report* report);
void StudyAge(const Setting& setting, Report* report);
void StudyLoad(const Setting& setting, Report* report);
void StudyBulk(const Setting& setting, Report* report);

}  // namespace transport
