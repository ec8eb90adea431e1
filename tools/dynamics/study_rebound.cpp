// Rebound under delay: energy gained or lost in an impact when contact data arrive late.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "physics/testing/closed_form/contact_laws.hpp"
#include "physics/testing/trials/rebound.hpp"
#include "tools/dynamics/bullet_rebound.hpp"
#include "tools/dynamics/studies.hpp"

namespace dynamics {
namespace {

using physics::trials::ReboundInput;
using physics::trials::ReboundParams;
using physics::trials::ReboundShape;

struct Input {
  const char* name;
  ReboundInput input;
};
constexpr Input kInputs[] = {
    {"wrench", ReboundInput::kWrench}, {"manifold", ReboundInput::kHard}, {"planes", ReboundInput::kPlanes}};

struct Shape {
  const char* name;
  ReboundShape shape;
};
constexpr Shape kShapes[] = {{"flat", ReboundShape::kFlat},
                             {"edge", ReboundShape::kEdge},
                             {"ball on floor", ReboundShape::kBall},
                             {"ball on ball", ReboundShape::kBalls},
                             {"corner on ball", ReboundShape::kVertex}};

constexpr double kMasses_kg[] = {0.2, 2.0, 20.0};
constexpr double kLeast = 0.98;
constexpr double kMost = 1.02;

Table MakeTable(const std::string& name) {
  return {
      name,
      {"input", "shape", "mass_kg", "stiffness_N_per_m", "spin_rad_per_s", "delay_ms", "phase", "ratio", "closed_form"},
      {}};
}

double Phase(const ReboundParams& p) {
  return std::sqrt(p.stiffness_N_per_m / p.mass_kg) * 1e-3 * p.delay_ms;
}

double Measure(const char* input, const char* shape, const ReboundParams& p, Table* table) {
  const double ratio = physics::trials::ReboundRatio(p);
  table->Add({input, shape, Cell(p.mass_kg), Cell(p.stiffness_N_per_m), Cell(p.spin_rad_per_s), Cell(p.delay_ms),
              Cell(Phase(p)), Cell(ratio),
              Cell(physics::closed_form::DelayedReboundRatio(p.stiffness_N_per_m, p.mass_kg, 1e-3 * p.delay_ms))});
  return ratio;
}

double FartherFromOne(double a, double b) {
  if (!std::isfinite(a) || !std::isfinite(b)) return std::isfinite(a) ? b : a;
  return std::abs(a - 1.0) > std::abs(b - 1.0) ? a : b;
}

Panel MakePanel(const std::string& title, const char* x_title, bool x_log, bool y_log) {
  Panel panel;
  panel.title = title;
  panel.x_title = x_title;
  panel.y_title = "speed after over before, by total energy";
  panel.x_log = x_log;
  panel.y_log = y_log;
  panel.bands = {{kMost, 1e9, "gains energy"}, {0.0, kLeast, "loses energy"}};
  return panel;
}

// Three masses, delays 0 to 7 ms, all over the dimensionless delay w tau.
Panel AgainstPhase(const std::string& title, const Shape& shape, double spin_rad_per_s, Table* table) {
  Panel panel = MakePanel(title, "delay times sqrt(stiffness / mass)", false, true);
  panel.y_low = 0.3;
  panel.y_high = 15.0;
  Series line{"exp(pi w t / 2)", {}, true};
  for (double phase = 0.0; phase < 1.6; phase += 0.03) {
    line.points.push_back({phase, physics::closed_form::DelayedReboundRatio(1.0, 1.0, phase), ""});
  }
  panel.series.push_back(line);
  for (const Input& input : kInputs) {
    Series series{input.name, {}, false};
    for (const double mass_kg : kMasses_kg) {
      for (int delay_ms = 0; delay_ms <= 7; ++delay_ms) {
        ReboundParams params;
        params.shape = shape.shape;
        params.input = input.input;
        params.mass_kg = mass_kg;
        params.spin_rad_per_s = spin_rad_per_s;
        params.delay_ms = delay_ms;
        const double ratio = Measure(input.name, shape.name, params, table);
        if (std::isfinite(ratio)) series.points.push_back({Phase(params), ratio, ""});
      }
    }
    panel.series.push_back(series);
  }
  return panel;
}

// Bullet's own compliant rows, without any delay.
void AddBullet(Table* table, Panel* panel) {
  Series series{"Bullet, not late", {}, false};
  for (const double mass_kg : kMasses_kg) {
    ReboundParams params;
    params.mass_kg = mass_kg;
    const double ratio = BulletReboundRatio(mass_kg, params.stiffness_N_per_m, params.speed_m_per_s);
    table->Add({"Bullet", "flat", Cell(mass_kg), Cell(params.stiffness_N_per_m), "0", "0", "0", Cell(ratio), "1"});
    series.points.push_back({0.0, ratio, Short(mass_kg) + " kg"});
    std::printf("Bullet's compliant contact, %g kg, not late: %.4f\n", mass_kg, ratio);
  }
  panel->series.push_back(series);
}

// Over the stiffness, at one mass and delay.
Panel AgainstStiffness(Table* table) {
  Panel panel = MakePanel("stiffness: 0.2 kg, 3 ms late", "N/m", true, true);
  panel.y_low = 0.3;
  panel.y_high = 100.0;
  Series line{"exp(pi w t / 2)", {}, true};
  for (const Input& input : kInputs) {
    Series series{input.name, {}, true};
    for (const double stiffness : {1e3, 3e3, 1e4, 3e4, 1e5}) {
      ReboundParams params;
      params.input = input.input;
      params.stiffness_N_per_m = stiffness;
      params.delay_ms = 3;
      const double ratio = Measure(input.name, "flat", params, table);
      if (std::isfinite(ratio)) series.points.push_back({stiffness, ratio, ""});
      if (input.input == ReboundInput::kWrench) {
        line.points.push_back({stiffness, physics::closed_form::DelayedReboundRatio(stiffness, 0.2, 3e-3), ""});
      }
    }
    panel.series.push_back(series);
  }
  panel.series.insert(panel.series.begin(), line);
  return panel;
}

// With planes only: the worst of the masses for every shape.
Panel OfShapes(Table* table, double* worst) {
  Panel panel = MakePanel("shapes, 0 to 2 rad/s", "delay [ms]", false, false);
  panel.y_low = 0.95;
  panel.y_high = 1.05;
  *worst = 1.0;
  for (const Shape& shape : kShapes) {
    Series series{shape.name, {}, true};
    for (int delay_ms = 0; delay_ms <= 7; ++delay_ms) {
      double of_delay = 1.0;
      for (const double mass_kg : kMasses_kg) {
        for (const double spin : {0.0, 2.0}) {
          ReboundParams params;
          params.shape = shape.shape;
          params.mass_kg = mass_kg;
          params.spin_rad_per_s = spin;
          params.delay_ms = delay_ms;
          of_delay = FartherFromOne(of_delay, Measure("planes", shape.name, params, table));
        }
      }
      *worst = FartherFromOne(*worst, of_delay);
      series.points.push_back({static_cast<double>(delay_ms), of_delay, ""});
    }
    panel.series.push_back(series);
  }
  return panel;
}

// The limit of the method: a round part that turns fast, with delayed planes.
Panel OfSpin(Table* table) {
  Panel panel = MakePanel("a ball on the floor that turns", "delay [ms]", false, false);
  panel.y_low = 0.9;
  panel.y_high = 1.15;
  for (const double spin : {2.0, 5.0, 10.0}) {
    Series series{Short(spin) + " rad/s", {}, true};
    for (int delay_ms = 0; delay_ms <= 7; ++delay_ms) {
      double worst = 1.0;
      for (const double mass_kg : kMasses_kg) {
        ReboundParams params;
        params.shape = ReboundShape::kBall;
        params.mass_kg = mass_kg;
        params.spin_rad_per_s = spin;
        params.delay_ms = delay_ms;
        worst = FartherFromOne(worst, Measure("planes", "ball on floor", params, table));
      }
      series.points.push_back({static_cast<double>(delay_ms), worst, ""});
    }
    panel.series.push_back(series);
  }
  return panel;
}

}  // namespace

void StudyRebound(const Peers& /*peers*/, Report* report) {
  Table table = MakeTable("rebound");
  double worst = 1.0;
  Chart inputs{
      "Contact under delay: what is left of a rebound's speed",
      "no damping, no friction, 0.1 m/s, 10 kN/m, 0.2 to 20 kg, 0 to 7 ms late; tinted: over 2 % gained or lost",
      {}};
  inputs.panels.push_back(AgainstPhase("a flat plate", kShapes[0], 0.0, &table));
  AddBullet(&table, &inputs.panels.back());
  inputs.panels.push_back(AgainstPhase("a box on its edge, 2 rad/s", kShapes[1], 2.0, &table));
  inputs.panels.push_back(AgainstPhase("a ball on the floor, 2 rad/s", kShapes[2], 2.0, &table));
  inputs.panels.push_back(AgainstStiffness(&table));
  Chart planes{
      "Contact under delay: planes with look-ahead, closer", "as before; the farthest from 1 of 0.2, 2 and 20 kg", {}};
  planes.panels.push_back(OfShapes(&table, &worst));
  planes.panels.push_back(OfSpin(&table));
  report->tables.push_back(table);
  report->charts.emplace_back("rebound", inputs);
  report->charts.emplace_back("rebound_planes", planes);
  std::printf("planes, 0 to 2 rad/s, 0 to 7 ms: %.4f at worst\n", worst);
  report->AddGoal("rebound, 10 kN/m, 0.2 to 20 kg, 0 to 7 ms, flat, edge, curved, 0 to 2 rad/s, `planes`",
                  "0.98 to 1.02", Cell(worst) + " at worst", worst >= kLeast && worst <= kMost);
  double of_fast = 1.0;
  for (const double mass_kg : kMasses_kg) {
    ReboundParams fast;
    fast.shape = ReboundShape::kBall;
    fast.mass_kg = mass_kg;
    fast.spin_rad_per_s = 10.0;
    fast.delay_ms = 7;
    of_fast = FartherFromOne(of_fast, physics::trials::ReboundRatio(fast));
  }
  report->AddGoal("the same, a ball of 30 mm that turns at 10 rad/s, 7 ms", "0.98 to 1.02", Short(of_fast),
                  of_fast >= kLeast && of_fast <= kMost);
}

}  // namespace dynamics
