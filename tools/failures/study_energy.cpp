// F8: does the hand get energy out of the scene? An operator with tremor reaches about a plate with a block on it.
#include <algorithm>
#include <cstdio>
#include <random>

#include "tools/failures/loop.hpp"
#include "tools/failures/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kSeconds = 600.0;
constexpr double kTremor_m = 0.00015;  // as device_bridge's operator

SceneKit PlateWithBlock(const Variant& variant) {
  SceneKit kit(variant);
  const auto plate =
      kit.AddFixed(vps::MakeBox({0.3, 0.3, kPlate_m}), {{1, 0, 0, 0}, {0, 0, -0.5 * kPlate_m}}, kVoxel_m);
  const auto block = kit.AddFixed(vps::MakeBox({0.06, 0.08, 0.05}), {{1, 0, 0, 0}, {0.05, 0.0, 0.025}}, kVoxel_m);
  kit.scenario.objects[plate].frames.push_back({"top", {{1, 0, 0, 0}, {0, 0, 0.5 * kPlate_m}}});
  const auto ball = kit.AddHand(vps::MakeSphere(kBall_m, 64), {{1, 0, 0, 0}, {-0.05, 0, 0.06}}, kToolPoints);
  kit.AddPair(ball, plate);
  kit.AddPair(ball, block);
  return kit;
}

// From random places above, which are always in reach, pushes down and aside, most of them into the plate or the block.
std::string Wander(double seconds) {
  std::mt19937_64 engine(7);
  const auto uniform = [&engine](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
  };
  std::string script;
  char line[200];
  for (double t = 0.0; t < seconds; t += 0.5) {
    std::snprintf(line, sizeof line,
                  "reach object0.top offset %.4f %.4f 0.085 turn %.1f %.1f %.1f speed %.2f within 0.05\n"
                  "push %.2f %.2f -1 by 0.1 speed %.2f until felt %.1f\n",
                  uniform(-0.06, 0.06), uniform(-0.06, 0.06), uniform(-15, 15), uniform(-15, 15), uniform(-15, 15),
                  uniform(0.1, 0.5), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 0.5), uniform(3, 12));
    script += line;
  }
  return script;
}

}  // namespace

void StudyEnergy(Report* report) {
  Row row{"F8",
          "energy generation",
          "10 min of pushes into a plate and a block, with tremor",
          "least energy that the hand has put in",
          ">= -1 mJ",
          {},
          "the force is late, and the controller acts only after energy has come back"};
  Panel panel;
  panel.title = "energy that the hand has put in";
  panel.x_title = "time [s]";
  panel.y_title = "[J]";
  panel.x_log = panel.y_log = false;
  Table table{"energy", {"contender", "time_s", "energy_J"}, {}};
  for (const Variant& variant : Variants()) {
    LoopOptions options;
    options.script = Wander(kSeconds);
    options.tremor_m = kTremor_m;
    options.command_delay_ticks = 1;
    Loop loop(PlateWithBlock(variant).scenario, options);
    Series series{variant.name, {}, true};
    for (int second = 0; second < static_cast<int>(kSeconds); ++second) {
      loop.Run(1.0);
      if (second % 5 != 0) continue;
      series.points.push_back({loop.now_s(), loop.energy_J(), ""});
      table.Add({variant.name, bench::Cell(loop.now_s()), bench::Cell(loop.energy_J())});
    }
    panel.series.push_back(series);
    row.readings.push_back({variant.name, Short(1e3 * loop.least_energy_J()) + " mJ", loop.least_energy_J() >= -1e-3});
  }
  report->tables.push_back(table);
  report->charts.emplace_back("energy", Chart{"F8: energy over ten minutes of tremulous motion", row.set_up, {panel}});
  AddRow(report, row);
}

}  // namespace failures
