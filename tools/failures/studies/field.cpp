// The local contact field in device_bridge beside the wrench alone: the stiffest wall against delay, the boundary of a
// mesh against the exact one of the device's own loop, and a link that dies under a pressing hand.
#include <algorithm>
#include <cmath>
#include <functional>

#include "stability/sampled_axis.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kGap_m = 1e-5;
constexpr double kPressed_m = 0.004;  // 4 N on a hand's spring of 1 kN/m: 0.1 mm of a wall of 40 kN/m
constexpr double kMost_N_per_m = 120e3;

struct Force {
  std::string name;
  bool has_field;
};
const std::vector<Force>& Forces() {
  static const std::vector<Force> forces{{"wrench", false}, {"field", true}};
  return forces;
}

// The default renders the field; the wrench's figure stands beside it.
Reading OfBoth(double wrench, double field, double unit, const std::string& unit_name, bool is_met) {
  return {Variants().back().name, Short(unit * field) + unit_name + " (wrench: " + Short(unit * wrench) + ")", is_met};
}

// The operator's arm of 30 N s/m on a device of 1.5 kg and 5 N s/m.
SceneKit Wall(double K_N_per_m, bool has_field) {
  SceneKit kit = BallOverPlate(Variants().back(), kGap_m);
  kit.scenario.coupling.stiffness_N_per_m = K_N_per_m;
  kit.scenario.coupling.has_field = has_field;
  kit.device().hand_stiffness_N_per_m = 1000.0;
  kit.device().hand_damping_N_s_per_m = 30.0;
  return kit;
}

LoopOptions Press(double by_m, int delay_ticks) {
  LoopOptions options;
  options.command_delay_ticks = delay_ticks;
  options.script = "wait 1.2\npush 0 0 -1 by " + std::to_string(by_m) + " speed 0.05\nwait 600";
  return options;
}

// The motion decays and the passivity controller has next to nothing to do: it alone would hold a loop that hammers.
bool IsQuiet(const SceneKit& kit, const LoopOptions& options) {
  Loop loop(kit.scenario, options);
  loop.Run(3.0);
  double fastest_m_per_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    loop.Tick();
    fastest_m_per_s = std::max(fastest_m_per_s, std::abs(loop.device().V_WD.linear_m_per_s.z));
  }
  return fastest_m_per_s < 1e-3 && loop.bridge().figures(0).share_made_passive() < 0.01 &&
         loop.energy().least_J() >= -1e-3;
}

double LargestQuiet(double low_N_per_m, const std::function<bool(double)>& is_quiet) {
  double low = low_N_per_m;
  double high = kMost_N_per_m;
  if (!is_quiet(low)) return 0.0;
  if (is_quiet(high)) return high;
  while (high / low > 1.02) {
    const double middle = std::sqrt(low * high);
    (is_quiet(middle) ? low : high) = middle;
  }
  return low;
}

void StudyWallWithField(Report* report) {
  Table table{"field_wall", {"force", "delay_ms", "K_N_per_m"}, {}};
  Panel panel;
  panel.title = "hand and device of 1.5 kg, 35 N s/m, 4 N";
  panel.x_title = "delay of the command [ms]";
  panel.y_title = "largest quiet K [N/m]";
  panel.x_log = false;
  Row row{"F7",
          "stiffness and delay",
          "hand and device of 1.5 kg, 3 ms late, mesh of a plate, pressed 0.1 mm deep with 4 N",
          "largest K that decays, controller in < 1 % of cycles",
          ">= 40 kN/m",
          {},
          "the whole stiffness is late"};
  std::vector<double> at_3_ms;
  for (const Force& force : Forces()) {
    Series series{force.name, {}, true};
    for (const int delay : {0, 1, 3, 5, 8}) {
      const double K =
          LargestQuiet(1e3, [&](double k) { return IsQuiet(Wall(k, force.has_field), Press(kPressed_m, delay)); });
      series.points.push_back({static_cast<double>(delay), K, ""});
      table.Add({force.name, std::to_string(delay), bench::Cell(K)});
      if (delay == 3) at_3_ms.push_back(K);
    }
    panel.series.push_back(series);
  }
  row.readings.push_back(OfBoth(at_3_ms[0], at_3_ms[1], 1e-3, " kN/m", at_3_ms[1] >= 4e4));
  report->tables.push_back(table);
  report->charts.emplace_back("field_wall", Chart{"F7: the stiffest wall, wrench and field", "1 kHz", {panel}});
  AddRow(report, row);
}

// A device by itself, leant on the wall by a constant force.
void StudyMeshWithField(Report* report) {
  Row row{"F7",
          "stiffness and delay",
          "device of 1.5 kg, 5 N s/m, 1 to 10 ms late, mesh of a plate, field",
          "largest quiet K over the exact one of the device's own loop",
          ">= 0.9",
          {},
          "what the field does not know of the mesh is late"};
  Table table{"field_mesh", {"delay_ms", "own_delay_ms", "exact_N_per_m", "K_N_per_m"}, {}};
  double least = 1e9;
  for (const double own_s : {0.0, 1e-3}) {
    const double exact = stability::MaxStiffness({1.5, 5.0, kTick_s, own_s}, 0.0);
    for (const int delay : {1, 3, 10}) {
      const double K = LargestQuiet(0.1 * exact, [&](double k) {
        SceneKit kit = Wall(k, true);
        kit.device().command_delay_s = own_s;
        kit.device().hand_stiffness_N_per_m = 1.0;
        kit.device().hand_damping_N_s_per_m = 0.0;
        LoopOptions options = Press(2.0, delay);
        options.script = "wait 1.2\npush 0 0 -1 by 2 speed 0.5\nwait 600";
        Loop loop(kit.scenario, options);
        loop.Run(8.0);
        double early = 0.0;
        double late = 0.0;
        for (int i = 0; i < 4000; ++i) {
          loop.Tick();
          double& sum = i < 2000 ? early : late;
          sum += loop.device().V_WD.linear_m_per_s.z * loop.device().V_WD.linear_m_per_s.z;
        }
        return late < std::max(early, 2e-7);
      });
      least = std::min(least, K / exact);
      table.Add({std::to_string(delay), bench::Cell(1e3 * own_s), bench::Cell(exact), bench::Cell(K)});
    }
  }
  row.readings.push_back({Variants().back().name, Short(least), least >= 0.9});
  report->tables.push_back(table);
  AddRow(report, row);
}

// Fastest in the 0.3 s after the link has died under 24 N.
double AfterTheLinkDied(double K_N_per_m, bool has_field, bool is_held) {
  Loop loop(Wall(K_N_per_m, has_field).scenario, Press(0.024 + 24.0 / K_N_per_m, 3));
  loop.Run(4.0);
  loop.CutLink();
  if (!is_held) loop.OpenHand();
  double fastest_m_per_s = 0.0;
  for (int i = 0; i < 300; ++i) {
    loop.Tick();
    fastest_m_per_s = std::max(fastest_m_per_s, glm::length(loop.device().V_WD.linear_m_per_s));
  }
  return fastest_m_per_s;
}

void StudyDeadLink(Report* report) {
  for (const bool is_held : {true, false}) {
    Row row{"F7",
            "stiffness and delay",
            std::string("link dies while 24 N are pressed at 2.5 to 40 kN/m (wrench: 2.5); the hand ") +
                (is_held ? "goes on pressing" : "lets go"),
            is_held ? "speed into the wall" : "speed of the fling",
            "<= 0.30 m/s",
            {},
            "the force is held too long, or is gone too soon"};
    double worst[2] = {0.0, 0.0};
    for (const double K_N_per_m : {2500.0, 10e3, 40e3}) {
      worst[1] = std::max(worst[1], AfterTheLinkDied(K_N_per_m, true, is_held));
    }
    worst[0] = AfterTheLinkDied(2500.0, false, is_held);
    row.readings.push_back(OfBoth(worst[0], worst[1], 1.0, " m/s", worst[1] <= 0.30));
    AddRow(report, row);
  }
}

}  // namespace

void StudyField(Report* report) {
  StudyWallWithField(report);
  StudyMeshWithField(report);
  StudyDeadLink(report);
}

}  // namespace failures
