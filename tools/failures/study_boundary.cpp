// F7: the wall that a delayed, sampled hand device can render. The operator leans on it by a soft spring, so that it
// stays in contact; it is stable if what is left of the motion decays. The bridge's passivity controller is part of the
// loop, so this is what a lab would find, not the boundary of the spring alone.
#include <array>
#include <cmath>
#include <functional>

#include "stability/sampled_axis.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kWindow_s = 3.0;

struct Hand {
  double mass_kg = 1.5;
  double damping_N_s_per_m = 5.0;      // of the device
  double stiffness_N_per_m = 1.0;      // of the operator's arm
  double arm_damping_N_s_per_m = 0.0;  // of the operator's arm
  double lean_m = 2.0;                 // how far the operator's target goes into the wall
};

double Bisect(double low, double high, double ratio, const std::function<bool(double)>& is_stable) {
  while (high / low > ratio) {
    const double middle = std::sqrt(low * high);
    (is_stable(middle) ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

// Of the device and the damping of the operator's arm; the arm's spring, soft beside the wall, is left out.
double ExactBoundary_N_per_m(const Hand& hand, int delay_ticks) {
  const stability::SampledAxis axis{hand.mass_kg, hand.damping_N_s_per_m + hand.arm_damping_N_s_per_m, kTick_s,
                                    kTick_s * delay_ticks};
  return stability::MaxStiffness(axis, 0.0);
}

void Fit(const Hand& hand, SceneKit* kit) {
  scene::Device& device = kit->device();
  device.mass_kg = hand.mass_kg;
  device.damping_N_s_per_m = hand.damping_N_s_per_m;
  device.hand_stiffness_N_per_m = hand.stiffness_N_per_m;
  device.hand_damping_N_s_per_m = hand.arm_damping_N_s_per_m;
}

LoopOptions Lean(const Hand& hand, int delay_ticks) {
  LoopOptions options;
  options.command_delay_ticks = delay_ticks;
  options.script = "wait 1.2\npush 0 0 -1 by " + std::to_string(hand.lean_m) + " speed " +
                   std::to_string(hand.lean_m / 4.0) + "\nwait 600";
  return options;
}

// What is left of the motion, by the rms of the speed in three windows one after the other.
class Decay {
 public:
  void Add(double t_s, double speed_m_per_s) {
    const auto window = static_cast<std::size_t>(t_s / kWindow_s);
    if (window < sums_.size()) sums_[window] += speed_m_per_s * speed_m_per_s;
  }
  // Decaying, or still to within a micrometre of motion at the boundary's frequencies.
  [[nodiscard]] bool is_stable() const {
    const double rest = 1e-10 * kWindow_s / kTick_s;  // (10 um/s)^2
    return sums_[2] < rest || (sums_[2] < sums_[1] && sums_[1] < sums_[0]);
  }

 private:
  std::array<double, 3> sums_{};
};
constexpr double kLeaning_s = 7.0;
constexpr double kRun_s = kLeaning_s + 3.0 * kWindow_s;

bool IsStable(const SceneKit& kit, const LoopOptions& options) {
  Loop loop(kit.scenario, options);
  loop.Run(kLeaning_s);
  Decay decay;
  while (loop.now_s() < kRun_s) {
    loop.Tick();
    decay.Add(loop.now_s() - kLeaning_s, loop.device().V_WD.linear_m_per_s.z);
  }
  return decay.is_stable();
}

// A wall that haptic_node makes of a plate's mesh.
bool IsStableOnMesh(const Variant& variant, const Hand& hand, double K_N_per_m, int delay_ticks) {
  SceneKit kit = BallOverPlate(variant, 1e-5);
  kit.scenario.coupling.stiffness_N_per_m = K_N_per_m;
  Fit(hand, &kit);
  return IsStable(kit, Lean(hand, delay_ticks));
}

// The plane z = 0 in closed form in place of haptic_node: only device_bridge takes part.
bool IsStableOnPlane(const Hand& hand, double K_N_per_m, int delay_ticks) {
  SceneKit kit = BallOverPlate(Variants().front(), 1e-5 - kBall_m);
  Fit(hand, &kit);
  LoopOptions options = Lean(hand, delay_ticks);
  options.answer = [K_N_per_m](const core::DeviceState& device) {
    return core::Wrench{{0, 0, K_N_per_m * std::max(0.0, -device.X_WD.translation.z)}, {}};
  };
  return IsStable(kit, options);
}

constexpr double kSearch = 4.0;  // factor to both sides of the exact boundary

// The largest stable stiffness, over the exact one.
double Ratio(const std::function<bool(double)>& is_stable, double exact_N_per_m, double precision) {
  const double low = exact_N_per_m / kSearch;
  const double high = exact_N_per_m * kSearch;
  if (!is_stable(low)) return 0.0;
  if (is_stable(high)) return kSearch;
  return Bisect(low, high, precision, is_stable) / exact_N_per_m;
}

struct Worst {
  double least = 1e9;
  double farthest = 1.0;  // from 1
  void Add(double ratio) {
    least = std::min(least, ratio);
    if (std::abs(ratio - 1.0) > std::abs(farthest - 1.0)) farthest = ratio;
  }
};

// Damping of the device over delay: exact lines, measured points.
void StudyMap(Report* report) {
  Table table{
      "boundary", {"wall", "mass_kg", "damping_N_s_per_m", "delay_ms", "exact_N_per_m", "measured_N_per_m"}, {}};
  Chart chart{"F7: the stiffest stable wall", "device of 1.5 kg, 1 kHz; lines: exact; points: simulated", {}};
  Worst plane;
  std::vector<Worst> of_variant(Variants().size());
  std::vector<Panel> panels(1 + Variants().size());
  panels[0].title = "plane in closed form";
  for (std::size_t i = 0; i < Variants().size(); ++i) panels[i + 1].title = "mesh of a plate, " + Variants()[i].name;
  for (Panel& panel : panels) {
    panel.x_title = "damping of the device [N s/m]";
    panel.y_title = "K [N/m]";
  }
  for (const int delay : {0, 1, 3, 10}) {
    const std::string name = std::to_string(delay) + " ms";
    std::vector<Series> points(panels.size(), {name + ", simulated", {}, false});
    Series exact{name, {}, true};
    for (const double b : {2.0, 5.0, 10.0}) {
      for (const double mass : {0.5, 1.5, 5.0}) {
        Hand hand;
        hand.mass_kg = mass;
        hand.damping_N_s_per_m = b;
        const double exact_N_per_m = ExactBoundary_N_per_m(hand, delay);
        const auto add = [&](const std::string& wall, double ratio, std::size_t panel) {
          table.Add({wall, bench::Cell(mass), bench::Cell(b), std::to_string(delay), bench::Cell(exact_N_per_m),
                     bench::Cell(ratio * exact_N_per_m)});
          if (mass == 1.5) points[panel].points.push_back({b, ratio * exact_N_per_m, ""});
        };
        const double ratio = Ratio([&](double K) { return IsStableOnPlane(hand, K, delay); }, exact_N_per_m, 1.002);
        plane.Add(ratio);
        add("plane", ratio, 0);
        if (mass != 1.5) continue;
        exact.points.push_back({b, exact_N_per_m, ""});
        for (std::size_t i = 0; i < Variants().size(); ++i) {
          const double of_mesh =
              Ratio([&](double K) { return IsStableOnMesh(Variants()[i], hand, K, delay); }, exact_N_per_m, 1.02);
          of_variant[i].Add(of_mesh);
          add(Variants()[i].name, of_mesh, i + 1);
        }
      }
    }
    for (std::size_t i = 0; i < panels.size(); ++i) {
      panels[i].series.push_back(exact);
      panels[i].series.push_back(points[i]);
    }
  }
  chart.panels = panels;
  report->tables.push_back(table);
  report->charts.emplace_back("boundary", chart);
  Row on_plane{
      "F7",
      "stiffness and delay",
      "device of 0.5, 1.5, 5 kg, 2 to 10 N s/m, 0 to 10 ms late, plane in closed form",
      "largest stable K over the exact one (4: end of the search)",
      "0.99 to 1.01",
      {},
      "the bridge's passivity controller keeps the loop stable beyond its boundary; without it the boundary is "
      "held by tests of libs/stability and of the simulated arm"};
  for (const Variant& variant : Variants())
    on_plane.readings.push_back({variant.name, Short(plane.farthest), std::abs(plane.farthest - 1.0) <= 0.01});
  AddRow(report, on_plane);
  Row on_mesh{"F7",
              "stiffness and delay",
              "device of 1.5 kg, 2 to 10 N s/m, 0 to 10 ms late, mesh of a plate",
              "largest stable K over the exact one (4: end of the search)",
              ">= 0.9",
              {},
              "the proxy follows the surface over some cycles, which is further delay"};
  for (std::size_t i = 0; i < Variants().size(); ++i)
    on_mesh.readings.push_back({Variants()[i].name, Short(of_variant[i].least), of_variant[i].least >= 0.9});
  AddRow(report, on_mesh);
}

// The largest stable stiffness against delay, of a hand that presses with 4 N.
void StudyWall(Report* report) {
  Hand hand;
  hand.stiffness_N_per_m = 1000.0;
  hand.arm_damping_N_s_per_m = 30.0;
  hand.lean_m = 0.004;
  Table table{"wall", {"contender", "delay_ms", "K_N_per_m"}, {}};
  Panel panel;
  panel.title = "hand and device of 1.5 kg, 35 N s/m, 4 N";
  panel.x_title = "delay [ms]";
  panel.y_title = "largest stable K [N/m]";
  panel.x_log = false;
  Row row{"F7",
          "stiffness and delay",
          "hand and device of 1.5 kg, 3 ms late, mesh of a plate, pressed with 4 N",
          "largest stable K (40.5: end of the search)",
          ">= 40 kN/m",
          {},
          "stable because the passivity controller damps; nothing in the bridge renders the wall locally"};
  Series exact{"exact, wrench", {}, true};
  std::vector<Series> series;
  for (const Variant& variant : Variants()) series.push_back({variant.name, {}, true});
  for (const int delay : {0, 1, 2, 3, 5, 8}) {
    const double exact_N_per_m = ExactBoundary_N_per_m(hand, delay);
    exact.points.push_back({static_cast<double>(delay), exact_N_per_m, ""});
    table.Add({"exact", std::to_string(delay), bench::Cell(exact_N_per_m)});
    for (std::size_t i = 0; i < Variants().size(); ++i) {
      const double K = exact_N_per_m * Ratio([&](double k) { return IsStableOnMesh(Variants()[i], hand, k, delay); },
                                             exact_N_per_m, 1.02);
      series[i].points.push_back({static_cast<double>(delay), K, ""});
      table.Add({Variants()[i].name, std::to_string(delay), bench::Cell(K)});
      if (delay == 3) row.readings.push_back({Variants()[i].name, Short(1e-3 * K) + " kN/m", K >= 4e4});
    }
  }
  panel.series.push_back(exact);
  panel.series.insert(panel.series.end(), series.begin(), series.end());
  report->tables.push_back(table);
  report->charts.emplace_back("wall", Chart{"F7: the stiffest stable wall against delay", "1 kHz", {panel}});
  AddRow(report, row);
}

}  // namespace

void StudyBoundary(Report* report) {
  StudyMap(report);
  StudyWall(report);
}

}  // namespace failures
