// A sheet over a wire: error of the sag and computing time against the number of cells.
#include <cmath>
#include <cstdio>

#include "physics/testing/closed_form/hanging_sheet.hpp"
#include "physics/testing/trials/drape.hpp"
#include "tools/dynamics/bullet_sheet.hpp"
#include "tools/dynamics/studies.hpp"
#include "tools/dynamics/turns.hpp"

namespace dynamics {

void StudyCloth(const Peers& /*peers*/, Report* report) {
  using physics::DrapeResult;
  const double exact_m = physics::closed_form::HangingSheetSag_m(
      0.5 * physics::kDrapeSide_m, physics::kDrapeWeight_N_per_m2, physics::kDrapeBendingStiffness_Nm);
  struct Kind {
    const char* name;
    DrapeResult (*drape)(int cells);
  };
  constexpr Kind kKinds[] = {{"ours", physics::Drape}, {"Bullet's soft body", BulletDrape}};
  constexpr int kSides[] = {4, 6, 8, 12, 16, 24};
  std::vector<DrapeResult> results(std::size(kKinds) * std::size(kSides));
  std::vector<std::function<void()>> pieces;
  for (const Kind& kind : kKinds) {
    for (const int cells : kSides) {
      pieces.emplace_back([&result = results[pieces.size()], cells, drape = kind.drape] { result = drape(cells); });
    }
  }
  const std::vector<double> us = TakeTurns(pieces, 1, 3);
  Table table{"cloth",
              {"contender", "cells_along_a_side", "nodes", "us_per_step", "sag_mm", "exact_sag_mm", "error_of_sag",
               "speed_at_the_end_mm_per_s"},
              {}};
  Panel error{
      "error of the sag against the exact curve", "us for a step of 1 ms", "relative error", {}, true, true, {}};
  Panel cost{"time of a step", "nodes", "us for a step of 1 ms", {}, true, true, {}};
  std::size_t at = 0;
  for (const Kind& kind : kKinds) {
    Series of_error{kind.name, {}, true};
    Series of_cost{kind.name, {}, true};
    for (const int cells : kSides) {
      const DrapeResult& r = results[at];
      const double step_us = us[at++] / static_cast<double>(r.num_steps);
      const double off = std::abs(r.sag_m / exact_m - 1.0);
      table.Add({kind.name, Cell(cells), Cell(r.num_nodes), Cell(step_us), Cell(1e3 * r.sag_m), Cell(1e3 * exact_m),
                 Cell(off), Cell(1e3 * r.speed_m_per_s)});
      const std::string mark = std::to_string(cells) + " x " + std::to_string(cells);
      of_error.points.push_back({step_us, off, mark});
      of_cost.points.push_back({static_cast<double>(r.num_nodes), step_us, ""});
      std::printf("%-20s %2d x %2d cells: %7.1f us a step, sag %.3f mm, exact %.3f mm\n", kind.name, cells, cells,
                  step_us, 1e3 * r.sag_m, 1e3 * exact_m);
    }
    error.series.push_back(of_error);
    cost.series.push_back(of_cost);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("cloth", Chart{"A sheet over a wire: error and time against the size of its cells",
                                             "0.25 m square, 0.6 kg/m2, bending stiffness 3 mNm, both halves hang at "
                                             "1 g; exact: Euler's elastica with its own weight",
                                             {error, cost}});
}

}  // namespace dynamics
