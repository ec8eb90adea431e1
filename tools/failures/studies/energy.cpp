// F8: does the hand get energy out of the scene? An operator with tremor, who moves in strokes of minimum jerk, reaches
// and pushes at random: in scenes of fixed parts, where no energy can be stored once the hand has let go, and in the
// scenarios that are shipped.
#include <algorithm>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <utility>

#include "scene/load_scenario.hpp"
#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kSeconds = 600.0;
constexpr double kTremor_m = 0.00015;  // as device_bridge's operator
constexpr double kLeast_J = -1e-3;
constexpr double kMostActing = 0.01;
constexpr double kLeastPutIn_J = 0.1;  // in ten minutes; less is a hand that touches nothing

class Uniform {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }

 private:
  std::mt19937_64 engine_{7};
};

// From random places about `height_m` beside a frame, in reach, pushes towards it along an axis of W and aside.
std::string Wander(const std::string& frame, double height_m, double reach_m, double aside, int axis = 2,
                   double towards = -1.0) {
  Uniform uniform;
  std::string script;
  char line[240];
  for (int i = 0; i < static_cast<int>(kSeconds / 0.5); ++i) {
    glm::dvec3 at(uniform(-reach_m, reach_m), uniform(-reach_m, reach_m), -towards * height_m);
    const double turn_x = uniform(-15, 15), turn_y = uniform(-15, 15), turn_z = uniform(-15, 15);
    const double reach_m_per_s = uniform(0.1, 0.5);
    glm::dvec3 push(uniform(-aside, aside), uniform(-aside, aside), towards);
    std::swap(at[axis], at.z);
    std::swap(push[axis], push.z);
    std::snprintf(line, sizeof line,
                  "reach %s offset %.4f %.4f %.4f turn %.1f %.1f %.1f speed %.2f within 0.05\n"
                  "push %.2f %.2f %.2f by 0.1 speed %.2f until felt %.1f\n",
                  frame.c_str(), at.x, at.y, at.z, turn_x, turn_y, turn_z, reach_m_per_s, push.x, push.y, push.z,
                  uniform(0.1, 0.5), uniform(3, 12));
    script += line;
  }
  return script;
}

// Takes an object by its frame "grip", fingers pointing down.
std::string Take(const std::string& object, double opening_m) {
  char text[300];
  std::snprintf(text, sizeof text,
                "grip 0.05\nreach %s.grip offset 0 0 0.06\nreach %s.grip speed 0.1 within 0.002\n"
                "grip %.3f force 30\nwait until held %s\n",
                object.c_str(), object.c_str(), opening_m, object.c_str());
  return text;
}

// Waves the module of `two_hands` with the left hand to and fro beside the plug and the other hand.
std::string HoldAndWave() {
  Uniform uniform;
  std::string script = Take("module", 0.018);
  char line[200];
  for (int i = 0; i < static_cast<int>(kSeconds / 0.5); ++i) {
    const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
    const double way_m = uniform(0.01, 0.06), speed_m_per_s = uniform(0.1, 0.5);
    std::snprintf(line, sizeof line, "push %.2f %.2f %.2f by %.3f speed %.2f\npush %.2f %.2f %.2f by %.3f speed %.2f\n",
                  x, y, z, way_m, speed_m_per_s, -x, -y, -z, way_m, speed_m_per_s);
    script += line;
  }
  return script;
}

// Pushes the held peg at and into its hole of 0.1 mm clearance, whose mouth it finds or not.
std::string HoldAndInsert() {
  Uniform uniform;
  std::string script = Take("peg", 0.016) + "push 0 0 1 by 0.06 speed 0.1\n";
  char line[240];
  for (int i = 0; i < static_cast<int>(kSeconds / 0.5); ++i) {
    std::snprintf(line, sizeof line,
                  "carry peg.tip to hole.mouth offset %.4f %.4f 0.01 speed %.2f within 0.05\n"
                  "push %.2f %.2f -1 by 0.04 speed %.2f until felt %.1f\n",
                  uniform(-0.003, 0.003), uniform(-0.003, 0.003), uniform(0.1, 0.3), uniform(-0.3, 0.3),
                  uniform(-0.3, 0.3), uniform(0.05, 0.2), uniform(3, 12));
    script += line;
  }
  return script;
}

struct EnergyScene {
  std::string name;
  scene::Scenario scenario;
  std::string script;
  bool takes_part = false;  // the script begins with a grasp
};

void AddTop(SceneKit* kit, std::uint16_t object, double z_m) {
  kit->scenario.objects[object].frames.push_back({"top", {{1, 0, 0, 0}, {0, 0, z_m}}});
}

EnergyScene PlateWithBlock(const Variant& variant) {
  SceneKit kit(variant);
  const auto plate =
      kit.AddFixed(vps::MakeBox({0.3, 0.3, kPlate_m}), {{1, 0, 0, 0}, {0, 0, -0.5 * kPlate_m}}, kVoxel_m);
  const auto block = kit.AddFixed(vps::MakeBox({0.06, 0.08, 0.05}), {{1, 0, 0, 0}, {0.05, 0.0, 0.025}}, kVoxel_m);
  AddTop(&kit, plate, 0.5 * kPlate_m);
  const auto ball = kit.AddHand(vps::MakeSphere(kBall_m, 64), {{1, 0, 0, 0}, {-0.05, 0, 0.06}}, kToolPoints);
  kit.AddPair(ball, plate);
  kit.AddPair(ball, block);
  return {"plate and block", kit.scenario, Wander("object0.top", 0.085, 0.06, 1.0)};
}

EnergyScene PegOverHole(const Variant& variant) {
  SceneKit kit(variant);
  const auto block = kit.AddFixed(vps::MakeBlockWithHole(0.08, 0.04, 0.0105, 64), {}, 5e-4);
  AddTop(&kit, block, 0.02);
  const auto peg = kit.AddHand(vps::MakeCylinder(0.01, 0.06, 64), {{1, 0, 0, 0}, {0, 0, 0.06}}, kToolPoints);
  kit.AddPair(peg, block);
  // Where the hole went through, a peg that finds its way meets no force, and the operator's push would not end.
  const auto floor = kit.AddFixed(vps::MakeBox({0.08, 0.08, 0.01}), {{1, 0, 0, 0}, {0, 0, -0.025}}, 5e-4);
  kit.AddPair(peg, floor);
  return {"peg and blind hole", kit.scenario, Wander("object0.top", 0.04, 0.004, 0.2)};
}

EnergyScene BoxOnTorus(const Variant& variant) {
  SceneKit kit(variant);
  const auto torus = kit.AddFixed(vps::MakeTorus(0.05, 0.02, 96, 64), {}, kVoxel_m);
  AddTop(&kit, torus, 0.02);
  const auto box = kit.AddHand(vps::MakeBox(glm::dvec3(0.03)), {{1, 0, 0, 0}, {0, 0, 0.09}}, kToolPoints);
  kit.AddPair(box, torus);
  return {"box and torus", kit.scenario, Wander("object0.top", 0.06, 0.06, 0.5)};
}

// A scenario that is shipped, with this operator in place of its own.
EnergyScene Shipped(const std::string& name, const std::string& script, bool takes_part = false) {
  auto scenario = scene::LoadScenario(std::filesystem::path("scenarios") / name);
  if (!scenario) throw std::runtime_error("no scenarios/" + name + " here");
  scenario->procedure.clear();  // its steps are not this operator's
  return {name, *scenario, script, takes_part};
}

std::vector<EnergyScene> ShippedScenes() {
  return {Shipped("touch", Wander("plate.centre", 0.06, 0.1, 1.0)),
          Shipped("peg_in_hole", Wander("hole.mouth", 0.08, 0.04, 0.5)),
          Shipped("peg_in_hole/tight.xml", HoldAndInsert(), true),
          Shipped("two_hands", HoldAndWave(), true),
          Shipped("service_robot", Wander("left_7.side", 0.05, 0.02, 0.3, 1, 1.0)),
          Shipped("module_replacement", Wander("switch_base.pivot", 0.08, 0.06, 0.5))};
}

struct Energy {
  double least_J = 0.0;
  double least_of_windows_J = 0.0;
  double share_acting = 0.0;
  Series series;
};

Energy Wear(const EnergyScene& scene, const Variant& variant) {
  LoopOptions options;
  options.script = scene.script;
  options.tremor_m = kTremor_m;
  options.command_delay_ticks = 1;
  Loop loop(scene.scenario, options);
  Energy energy;
  energy.series = {variant.name, {}, true};
  constexpr int kTaken_s = 20;
  for (int second = 0; second < static_cast<int>(kSeconds); ++second) {
    loop.Run(1.0);
    if (second == kTaken_s && scene.takes_part && !loop.is_holding())
      throw std::runtime_error("the operator of " + scene.name + " has not taken the part");
    if (second % 5 == 0) energy.series.points.push_back({loop.now_s(), loop.energy().energy_J(), ""});
  }
  if (loop.energy().energy_J() < kLeastPutIn_J) throw std::runtime_error("nothing is pushed in " + scene.name);
  energy.least_J = loop.energy().least_J();
  energy.least_of_windows_J = loop.energy().least_of_windows_J();
  energy.share_acting = loop.bridge().figures(0).share_made_passive();
  return energy;
}

std::string Percent(double share) {
  return Short(100.0 * share) + " %";
}

std::string Millijoules(double energy_J) {
  return Short(1e3 * energy_J) + " mJ";
}

class Charting {
 public:
  explicit Charting(Report* report) : report_(report) {}
  ~Charting() {
    report_->tables.push_back(table_);
    report_->charts.emplace_back("energy", chart_);
  }
  Charting(const Charting&) = delete;
  Charting& operator=(const Charting&) = delete;

  void Begin(const std::string& scene) {
    chart_.panels.emplace_back();
    Panel& panel = chart_.panels.back();
    panel.title = scene;
    panel.x_title = "time [s]";
    panel.y_title = "[J]";
    panel.x_log = panel.y_log = false;
  }
  void Add(const Series& series) {
    chart_.panels.back().series.push_back(series);
    for (const ChartPoint& point : series.points)
      table_.Add({chart_.panels.back().title, series.name, bench::Cell(point.x), bench::Cell(point.y)});
  }

 private:
  Report* report_;
  Chart chart_{"F8: energy over ten minutes of tremulous motion", "put in by the hand, 1.3 ms late", {}};
  Table table_{"energy", {"scene", "contender", "time_s", "energy_J"}, {}};
};

void AddFixedScenes(const std::vector<EnergyScene>& scenes, const std::vector<Energy>& energies, Charting* charting,
                    Report* report) {
  const std::size_t num_variants = Variants().size();
  for (std::size_t s = 0; s < scenes.size() / num_variants; ++s) {
    const std::string& name = scenes[s * num_variants].name;
    charting->Begin(name);
    Row row{"F8",
            "energy generation",
            "10 min of pushes by an operator with tremor, " + name + ", 1.3 ms late",
            "least energy put in; of any time between two instants without force, with the device's damping; share of "
            "cycles with the controller",
            ">= -1 mJ; >= -1 mJ; < 1 %",
            {},
            "the force is late, and the controller acts only after more has come back than was ever put in"};
    for (std::size_t v = 0; v < num_variants; ++v) {
      const Energy& energy = energies[s * num_variants + v];
      charting->Add(energy.series);
      row.readings.push_back(
          {Variants()[v].name,
           Millijoules(energy.least_J) + "; " + Millijoules(energy.least_of_windows_J) + "; " +
               Percent(energy.share_acting),
           energy.least_J >= kLeast_J && energy.least_of_windows_J >= kLeast_J && energy.share_acting < kMostActing});
    }
    AddRow(report, row);
  }
}

// Parts that move keep energy beyond a touch, so only the sum since the beginning is a bound here.
void AddShippedScene(const EnergyScene& scene, const Energy& energy, Charting* charting, Report* report) {
  charting->Begin(scene.name);
  charting->Add(energy.series);
  Row row{"F8",
          "energy generation",
          "10 min of pushes by an operator with tremor, scenario `" + scene.name + "` as it is shipped" +
              (scene.takes_part ? ", with a part in the hand" : "") + ", 1.3 ms late",
          "least energy put in; share of cycles with the controller",
          ">= -1 mJ; < 1 %",
          {},
          "parts that move, and mechanisms, give energy that was in the scene at the start"};
  row.readings.push_back({Variants().back().name, Millijoules(energy.least_J) + "; " + Percent(energy.share_acting),
                          energy.least_J >= kLeast_J && energy.share_acting < kMostActing});
  AddRow(report, row);
}

}  // namespace

void StudyEnergy(Report* report) {
  std::vector<EnergyScene> scenes;
  for (const auto make : {PlateWithBlock, PegOverHole, BoxOnTorus}) {
    for (const Variant& variant : Variants()) scenes.push_back(make(variant));
  }
  const std::vector<EnergyScene> shipped = ShippedScenes();
  std::vector<Energy> energies(scenes.size());
  std::vector<Energy> of_shipped(shipped.size());
  // The long ones first.
  ForAll(shipped.size() + scenes.size(), [&](std::size_t i) {
    if (i < shipped.size()) {
      of_shipped[i] = Wear(shipped[i], Variants().back());
    } else {
      const std::size_t k = i - shipped.size();
      energies[k] = Wear(scenes[k], Variants()[k % Variants().size()]);
    }
  });
  Charting charting(report);
  AddFixedScenes(scenes, energies, &charting, report);
  for (std::size_t i = 0; i < shipped.size(); ++i) AddShippedScene(shipped[i], of_shipped[i], &charting, report);
}

}  // namespace failures
