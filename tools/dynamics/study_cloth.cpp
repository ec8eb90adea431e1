// A sheet over a wire: what coarser cells do to its answer, and what finer ones cost.
#include <cmath>
#include <cstdio>

#include "physics/closed_form/hanging_sheet.hpp"
#include "physics/cloth/drape.hpp"
#include "tools/dynamics/studies.hpp"
#include "tools/dynamics/turns.hpp"

namespace dynamics {

void StudyCloth(const Peers& /*peers*/, Report* report) {
  using physics::DrapeResult;
  const double exact_m = physics::closed_form::HangingSheetSag_m(
      0.5 * physics::kDrapeSide_m, physics::kDrapeWeight_N_per_m2, physics::kDrapeBendingStiffness_Nm);
  const std::vector<int> sides = {4, 6, 8, 12, 16, 24};
  std::vector<DrapeResult> results(sides.size());
  std::vector<std::function<void()>> pieces;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    pieces.emplace_back([&result = results[i], cells = sides[i]] { result = physics::Drape(cells); });
  }
  const std::vector<double> us = TakeTurns(pieces, 1, 3);
  Table table{"cloth",
              {"cells_along_a_side", "nodes", "us_per_step", "sag_mm", "exact_sag_mm", "error_of_sag",
               "speed_at_the_end_mm_per_s"},
              {}};
  Panel error{
      "error of the sag against the exact curve", "us for a step of 1 ms", "relative error", {}, true, true, {}};
  Panel cost{"time of a step", "nodes", "us for a step of 1 ms", {}, true, true, {}};
  Series of_error{"sheet", {}, true};
  Series of_cost{"sheet", {}, true};
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const DrapeResult& r = results[i];
    const double step_us = us[i] / static_cast<double>(r.num_steps);
    const double off = std::abs(r.sag_m / exact_m - 1.0);
    table.Add({Cell(sides[i]), Cell(r.num_nodes), Cell(step_us), Cell(1e3 * r.sag_m), Cell(1e3 * exact_m), Cell(off),
               Cell(1e3 * r.speed_m_per_s)});
    const std::string mark = std::to_string(sides[i]) + " x " + std::to_string(sides[i]);
    of_error.points.push_back({step_us, off, mark});
    of_cost.points.push_back({static_cast<double>(r.num_nodes), step_us, mark});
    std::printf("sheet of %2d x %2d cells: %7.1f us a step, sag %.3f mm, exact %.3f mm\n", sides[i], sides[i], step_us,
                1e3 * r.sag_m, 1e3 * exact_m);
  }
  error.series.push_back(of_error);
  cost.series.push_back(of_cost);
  report->tables.push_back(table);
  report->charts.emplace_back("cloth", Chart{"A sheet over a wire: error and time against the size of its cells",
                                             "0.25 m square, 0.6 kg/m2, bending stiffness 3 mNm, both halves hang at "
                                             "1 g; exact: Euler's elastica with its own weight",
                                             {error, cost}});
}

}  // namespace dynamics
