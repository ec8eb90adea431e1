// F7: the wall that a delayed, sampled hand device can render. The operator leans on it by a soft spring, so that it
// stays in contact; it is stable if it does, and what is left of the motion decays. The bridge's passivity controller
// is off: it keeps the loop quiet far beyond the boundary that is to be found here.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "stability/sampled_axis.hpp"
#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
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
stability::SampledAxis AxisOf(const Hand& hand, int delay_ticks) {
  return {hand.mass_kg, hand.damping_N_s_per_m + hand.arm_damping_N_s_per_m, kTick_s,
          kTick_s * delay_ticks + 1e-9 * static_cast<double>(kAnswer_ns)};
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
  options.is_made_passive = false;
  options.script = "wait 1.2\npush 0 0 -1 by " + std::to_string(hand.lean_m) + " speed " +
                   std::to_string(hand.lean_m / 4.0) + "\nwait 600";
  return options;
}

// What is left of the motion, by the rms of the speed in three windows one after the other.
class Decay {
 public:
  explicit Decay(double rest_m_per_s) : rest_(rest_m_per_s * rest_m_per_s * 0.5 * kWindow_s / kTick_s) {}
  void Add(double t_s, double speed_m_per_s) {
    const auto window = static_cast<std::size_t>(t_s / kWindow_s);
    const double weight = std::sin(std::numbers::pi * t_s / kWindow_s);  // so that parts of a period do not count
    if (window < sums_.size()) sums_[window] += weight * weight * speed_m_per_s * speed_m_per_s;
  }
  [[nodiscard]] bool is_stable() const { return sums_[2] < rest_ || (sums_[2] < sums_[1] && sums_[1] < sums_[0]); }

 private:
  double rest_;
  std::array<double, 3> sums_{};
};
constexpr double kLeaning_s = 7.0;
constexpr double kRun_s = kLeaning_s + 3.0 * kWindow_s;

// At rest is what moves by less than a tenth of a micrometre at the frequency of the wall, sqrt(K / m): three orders
// below the depth that the operator leans in by, and above the rounding of the messages' forces.
constexpr double kRest_m = 1e-7;

// A wall that throws the hand off again and again is not stable: bounces between hand and wall do not grow for ever, so
// that one window may well have less of them than the window before.
bool IsStable(const SceneKit& kit, const LoopOptions& options, double K_N_per_m, double mass_kg) {
  Loop loop(kit.scenario, options);
  loop.Run(kLeaning_s);
  Decay decay(kRest_m * std::sqrt(K_N_per_m / mass_kg));
  while (loop.now_s() < kRun_s) {
    loop.Tick();
    if (!(loop.command().force_N.z > 0.0)) return false;
    decay.Add(loop.now_s() - kLeaning_s, loop.device().V_WD.linear_m_per_s.z);
  }
  return decay.is_stable();
}

// A wall that haptic_node makes of a plate's mesh.
bool IsStableOnMesh(const Variant& variant, const Hand& hand, double K_N_per_m, int delay_ticks) {
  SceneKit kit = BallOverPlate(variant, 1e-5);
  kit.scenario.coupling.stiffness_N_per_m = K_N_per_m;
  Fit(hand, &kit);
  return IsStable(kit, Lean(hand, delay_ticks), K_N_per_m, hand.mass_kg);
}

// A stiff wall that damps may throw off a hand that lands on it, and be quiet under one that leans on it: stability at
// rest is to be found here. So the hand lands on half of the wall, which is whole long before the leaning is over.
double ShareOfWall(double t_s) {
  constexpr double kLanded_s = 4.0;
  constexpr double kWhole_s = 6.0;
  return std::clamp(0.5 + 0.5 * (t_s - kLanded_s) / (kWhole_s - kLanded_s), 0.5, 1.0);
}

// The plane z = 0 in closed form in place of haptic_node: only device_bridge takes part.
bool IsStableOnPlane(const Hand& hand, const stability::Wall& wall, int delay_ticks) {
  SceneKit kit = BallOverPlate(Variants().front(), 1e-5 - kBall_m);
  Fit(hand, &kit);
  LoopOptions options = Lean(hand, delay_ticks);
  options.answer = [wall, before_m = 1e-5, t_s = 0.0](const core::DeviceState& device) mutable {
    t_s += kTick_s;
    const double share = ShareOfWall(t_s);
    const double depth_m = -device.X_WD.translation.z;
    const double rate_m_per_s = (depth_m + before_m) / kTick_s;
    before_m = -depth_m;
    if (depth_m <= 0.0) return core::Wrench{};
    const double force_N = wall.stiffness_N_per_m * depth_m + wall.damping_N_s_per_m * rate_m_per_s;
    return core::Wrench{{0, 0, share * std::max(0.0, force_N)}, {}};
  };
  return IsStable(kit, options, wall.stiffness_N_per_m, hand.mass_kg);
}

constexpr double kSearch = 8.0;  // factor to both sides of the exact boundary

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

// One place of the boundary.
struct Case {
  std::size_t panel = 0;  // of the chart; 0: the plane in closed form
  Hand hand;
  int delay_ticks = 0;
  double wall_damping_N_s_per_m = 0.0;
  double exact_N_per_m = 0.0;
  double ratio = 0.0;  // found: the largest stable K over the exact one
};

void Find(Case* one) {
  const auto is_stable = [one](double K) {
    if (one->panel > 0) return IsStableOnMesh(Variants()[one->panel - 1], one->hand, K, one->delay_ticks);
    return IsStableOnPlane(one->hand, {K, one->wall_damping_N_s_per_m}, one->delay_ticks);
  };
  one->ratio = Ratio(is_stable, one->exact_N_per_m, one->panel > 0 ? 1.04 : 1.002);
}

constexpr int kDelays_ticks[] = {0, 1, 3, 10};

// Device's damping over delay: exact lines, measured points.
std::vector<Case> CasesOfMap() {
  std::vector<Case> cases;
  for (const int delay : kDelays_ticks) {
    for (const double b : {2.0, 5.0, 10.0}) {
      for (const double mass : {0.5, 1.5, 5.0}) {
        Case one;
        one.hand.mass_kg = mass;
        one.hand.damping_N_s_per_m = b;
        one.delay_ticks = delay;
        one.exact_N_per_m = stability::MaxStiffness(AxisOf(one.hand, delay), 0.0);
        for (one.panel = 0; one.panel <= (mass == 1.5 ? Variants().size() : 0); ++one.panel) cases.push_back(one);
      }
    }
  }
  return cases;
}

// The wall's own damping over delay, of a device without any.
std::vector<Case> CasesOfWallDamping() {
  std::vector<Case> cases;
  for (const int delay : kDelays_ticks) {
    Case one;
    one.hand.damping_N_s_per_m = 0.0;
    one.hand.stiffness_N_per_m = 4.0;  // leans with 20 N: the motion is to stay small beside the depth
    one.hand.lean_m = 5.0;
    one.delay_ticks = delay;
    const stability::SampledAxis axis = AxisOf(one.hand, delay);
    for (const double share : {0.2, 0.5, 1.0, 1.3}) {
      one.wall_damping_N_s_per_m = share * stability::StiffestWall(axis).damping_N_s_per_m;
      one.exact_N_per_m = stability::MaxStiffness(axis, one.wall_damping_N_s_per_m);
      cases.push_back(one);
    }
  }
  return cases;
}

// Exact lines and found points by `x`, one pair of series for each delay.
Panel PanelOf(const std::vector<Case>& cases, std::size_t panel_index, const std::function<double(const Case&)>& x) {
  Panel panel;
  panel.y_title = "K [N/m]";
  for (const int delay : kDelays_ticks) {
    const std::string name = std::to_string(delay) + " ms";
    Series exact{name, {}, true};
    Series found{name + ", simulated", {}, false};
    for (const Case& one : cases) {
      if (one.panel != panel_index || one.delay_ticks != delay || one.hand.mass_kg != 1.5) continue;
      exact.points.push_back({x(one), one.exact_N_per_m, ""});
      found.points.push_back({x(one), one.ratio * one.exact_N_per_m, ""});
    }
    panel.series.push_back(exact);
    panel.series.push_back(found);
  }
  return panel;
}

void ChartMap(const std::vector<Case>& map, const std::vector<Case>& damped, Report* report) {
  Table table{"boundary",
              {"wall", "mass_kg", "damping_N_s_per_m", "wall_damping_N_s_per_m", "delay_ms", "exact_N_per_m",
               "measured_N_per_m"},
              {}};
  for (const std::vector<Case>* cases : {&map, &damped}) {
    for (const Case& one : *cases) {
      table.Add({one.panel == 0 ? "plane" : Variants()[one.panel - 1].name, bench::Cell(one.hand.mass_kg),
                 bench::Cell(one.hand.damping_N_s_per_m), bench::Cell(one.wall_damping_N_s_per_m),
                 std::to_string(one.delay_ticks), bench::Cell(one.exact_N_per_m),
                 bench::Cell(one.ratio * one.exact_N_per_m)});
    }
  }
  report->tables.push_back(table);
  Chart chart{"F7: the stiffest stable wall",
              "device of 1.5 kg, 1 kHz, 0.3 ms later than the legend says; lines: exact; points: simulated",
              {}};
  for (std::size_t i = 0; i <= Variants().size(); ++i) {
    Panel panel = PanelOf(map, i, [](const Case& one) { return one.hand.damping_N_s_per_m; });
    panel.title = i == 0 ? "plane in closed form" : "mesh of a plate, " + Variants()[i - 1].name;
    panel.x_title = "damping of the device [N s/m]";
    chart.panels.push_back(panel);
  }
  Panel panel = PanelOf(damped, 0, [](const Case& one) { return one.wall_damping_N_s_per_m; });
  panel.title = "plane in closed form, device without damping";
  panel.x_title = "damping of the wall [N s/m]";
  chart.panels.push_back(panel);
  report->charts.emplace_back("boundary", chart);
}

void StudyMap(Report* report) {
  std::vector<Case> map = CasesOfMap();
  std::vector<Case> damped = CasesOfWallDamping();
  std::vector<Case*> all;
  for (std::vector<Case>* cases : {&map, &damped})
    for (Case& one : *cases) all.push_back(&one);
  ForAll(all.size(), [&all](std::size_t i) { Find(all[i]); });
  ChartMap(map, damped, report);
  std::vector<Worst> worst(1 + Variants().size());  // by panel
  for (const Case* one : all) worst[one->panel].Add(one->ratio);
  Row on_plane{"F7",
               "stiffness and delay",
               "device of 0.5, 1.5, 5 kg, 0 to 10 N s/m, 0.3 to 10.3 ms late, plane in closed form",
               "largest stable K over the exact one (8: end of the search)",
               "0.99 to 1.01",
               {},
               "the arm or the filter between command and force adds delay"};
  Row on_mesh = on_plane;
  on_mesh.set_up = "device of 1.5 kg, 2 to 10 N s/m, 0.3 to 10.3 ms late, mesh of a plate";
  on_mesh.bound = ">= 0.9";
  on_mesh.why = "the proxy follows the surface over some cycles, which is further delay";
  for (std::size_t i = 0; i < Variants().size(); ++i) {
    const std::string& name = Variants()[i].name;
    on_plane.readings.push_back({name, Short(worst[0].farthest), std::abs(worst[0].farthest - 1.0) <= 0.01});
    on_mesh.readings.push_back({name, Short(worst[i + 1].least), worst[i + 1].least >= 0.9});
  }
  AddRow(report, on_plane);
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
          "hand and device of 1.5 kg, 3.3 ms late, mesh of a plate, pressed with 4 N",
          "largest stable K",
          ">= 40 kN/m",
          {},
          "the force is that of a pose which is 3 ms old"};
  constexpr int kWallDelays_ticks[] = {0, 1, 2, 3, 5, 8};
  const std::size_t num_variants = Variants().size();
  std::vector<Case> cases;
  for (const int delay : kWallDelays_ticks) {
    for (std::size_t i = 0; i < num_variants; ++i)
      cases.push_back({i + 1, hand, delay, 0.0, stability::MaxStiffness(AxisOf(hand, delay), 0.0), 0.0});
  }
  ForAll(cases.size(), [&cases](std::size_t i) { Find(&cases[i]); });
  Series exact{"exact, wrench", {}, true};
  std::vector<Series> series;
  for (const Variant& variant : Variants()) series.push_back({variant.name, {}, true});
  for (const Case& one : cases) {
    const double K = one.exact_N_per_m * one.ratio;
    const std::string& name = Variants()[one.panel - 1].name;
    if (one.panel == 1) {
      exact.points.push_back({static_cast<double>(one.delay_ticks), one.exact_N_per_m, ""});
      table.Add({"exact", std::to_string(one.delay_ticks), bench::Cell(one.exact_N_per_m)});
    }
    series[one.panel - 1].points.push_back({static_cast<double>(one.delay_ticks), K, ""});
    table.Add({name, std::to_string(one.delay_ticks), bench::Cell(K)});
    if (one.delay_ticks == 3) row.readings.push_back({name, Short(1e-3 * K) + " kN/m", K >= 4e4});
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
