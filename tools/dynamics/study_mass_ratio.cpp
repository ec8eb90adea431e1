// A heavy block on a light one: the solver's residual against the mass ratio.
#include <cstdio>

#include "tools/dynamics/studies.hpp"
#include "tools/dynamics/turns.hpp"

namespace dynamics {
namespace {

constexpr double kRatios[] = {1, 10, 100, 1000, 5000};
constexpr int kSteps = 1000;

}  // namespace

void StudyMassRatio(const Peers& peers, Report* report) {
  std::vector<StackMaker> makers = OwnStacks();
  makers.insert(makers.end(), peers.stacks.begin(), peers.stacks.end());
  Table table{"mass_ratio", {"contender", "mass_ratio", "overlap_um", "us_per_step"}, {}};
  Panel overlap{"overlap in the first second", "mass of the upper over the lower block", "um", {}, true, true, {}};
  Panel time{"time of a step", "mass of the upper over the lower block", "us", {}, true, true, {}};
  overlap.bands = {{50.0, 1e9, "more than 50 um"}};
  for (const StackMaker& maker : makers) {
    overlap.series.push_back({maker.name, {}, true});
    time.series.push_back({maker.name, {}, true});
  }
  double worst_um = 0.0;
  double worst_us = 0.0;
  for (const double ratio : kRatios) {
    std::vector<std::shared_ptr<Stack>> stacks;
    std::vector<std::function<void()>> pieces;
    std::vector<double> overlap_um;
    for (const StackMaker& maker : makers) {
      stacks.push_back(maker.make(ratio));
      for (int i = 0; i < kSteps; ++i) stacks.back()->Step();
      overlap_um.push_back(1e6 * stacks.back()->deepest_m());
      pieces.emplace_back([stack = stacks.back()] { stack->Step(); });
    }
    const std::vector<double> us = TakeTurns(pieces, 100, 15);
    for (std::size_t i = 0; i < makers.size(); ++i) {
      table.Add({makers[i].name, Cell(ratio), Cell(overlap_um[i]), Cell(us[i])});
      overlap.series[i].points.push_back({ratio, overlap_um[i], ""});
      time.series[i].points.push_back({ratio, us[i], ""});
      std::printf("%-26s %5g:1  overlap %9.3g um  %7.2f us\n", makers[i].name.c_str(), ratio, overlap_um[i], us[i]);
    }
    if (ratio >= 1000.0) {
      worst_um = std::max(worst_um, overlap_um[0]);
      worst_us = std::max(worst_us, us[0]);
    }
  }
  report->tables.push_back(table);
  report->charts.emplace_back("mass_ratio", Chart{"Heavy on light: overlap and time against the mass ratio",
                                                  "blocks of 0.1 m, the lower one of 0.2 kg, weights at 1 g from the "
                                                  "first step on, friction 0.3, steps of 1 ms",
                                                  {overlap, time}});
  report->AddGoal("1000:1 and 5000:1, heavy on light, 1 g, `manifold`: overlap", "<= 50 um", Short(worst_um) + " um",
                  worst_um <= 50.0);
  report->AddGoal("1000:1 and 5000:1: time of a step", "<= 200 us", Short(worst_us) + " us", worst_us <= 200.0);
}

}  // namespace dynamics
