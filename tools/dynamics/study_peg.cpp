// A peg in a hole: the jamming moment against Whitney's theory.
#include <cmath>
#include <cstdio>

#include "physics/testing/closed_form/contact_laws.hpp"
#include "physics/testing/trials/peg.hpp"
#include "tools/dynamics/studies.hpp"

namespace dynamics {

void StudyPeg(const Peers& /*peers*/, Report* report) {
  struct Kind {
    const char* name;
    physics::ContactKind kind;
  };
  Table table{"peg",
              {"contact", "clearance_of_half_width", "friction", "side_force_of_push", "depth_of_width", "jams_at_Nm",
               "theory_Nm", "ratio"},
              {}};
  Panel moment{
      "moment at which it jams", "depth over width", "moment over half width times push", {}, false, false, {}};
  Panel ratio{
      "beside theory", "clearance over half width", "measured moment over theory's, worst", {}, true, false, {}};
  ratio.y_low = 0.7;
  ratio.y_high = 1.3;
  Series theory{"theory", {}, true};
  for (const double depth : {0.6, 2.6}) theory.points.push_back({depth, depth / 0.25, ""});
  moment.series.push_back(theory);
  double worst_tight = 0.0;
  for (const Kind& kind :
       {Kind{"hard", physics::ContactKind::kHard}, Kind{"compliant", physics::ContactKind::kCompliant}}) {
    Series of_ratio{kind.name, {}, true};
    for (const double clearance : {0.0005, 0.002, 0.01, 0.05}) {
      double worst = 1.0;
      Series of_moment{kind.name, {}, false};
      for (const double friction : {0.1, 0.25}) {
        for (const double side : {0.0, 0.2}) {
          for (const double depth : {0.75, 1.5, 2.5}) {
            physics::trials::PegParams params;
            params.kind = kind.kind;
            params.friction = friction;
            params.depth_m = 2.0 * depth * params.half_width_m;
            params.clearance_m = clearance * params.half_width_m;
            params.F_x_N = side * params.F_z_N;
            if (physics::closed_form::CanWedge(params.depth_m, params.half_width_m, friction)) continue;
            const double exact_Nm = physics::closed_form::JammingMoment_Nm(params.depth_m, params.half_width_m,
                                                                           friction, params.F_x_N, params.F_z_N);
            const double found_Nm = physics::trials::FindJammingMoment_Nm(params);
            const double off = found_Nm / exact_Nm;
            if (std::abs(off - 1.0) > std::abs(worst - 1.0)) worst = off;
            table.Add({kind.name, Cell(clearance), Cell(friction), Cell(side), Cell(depth), Cell(found_Nm),
                       Cell(exact_Nm), Cell(off)});
            if (friction == 0.25 && side == 0.0) {
              of_moment.points.push_back({depth, found_Nm / (params.half_width_m * params.F_z_N), ""});
            }
          }
        }
      }
      if (clearance == 0.002) moment.series.push_back(of_moment);
      of_ratio.points.push_back({clearance, worst, ""});
      if (kind.kind == physics::ContactKind::kHard && clearance <= 0.002) {
        worst_tight = std::max(worst_tight, std::abs(worst - 1.0));
      }
      std::printf("peg, %-10s clearance %6g: jams at %.4f of theory's moment at worst\n", kind.name, clearance, worst);
    }
    ratio.series.push_back(of_ratio);
  }
  report->tables.push_back(table);
  report->charts.emplace_back(
      "peg", Chart{"A peg in a hole: where it jams",
                   "two-point contact; left with friction 0.25, no force aside, clearance 0.002, right the "
                   "worst of frictions 0.1 and 0.25, forces aside 0 and 0.2, depths 0.75 to 2.5",
                   {moment, ratio}});
  report->AddGoal("peg with clearance up to 0.2 %, hard contact: moment at which it jams against theory", "within 2 %",
                  Short(100.0 * worst_tight) + " % off", worst_tight <= 0.02);
}

}  // namespace dynamics
