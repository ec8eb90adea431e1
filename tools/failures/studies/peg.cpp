// F5: a round peg as the hand's tool into a hole.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kPeg_m = 0.01;  // radius
constexpr double kLength_m = 0.06;
constexpr double kHole_m = 0.04;  // its depth
constexpr double kSpeed_m_per_s = 0.02;
constexpr double kMostTilt_rad = 2.0 * std::numbers::pi / 180.0;
constexpr int kSegments = 128;
constexpr double kIn_m = 0.001;        // behind the device
constexpr double kLeast_m = 0.001;     // a peg that is not in the hole has no two-point contact
constexpr double kClearLag_m = 0.001;  // of a force that is compared

struct Insertion {
  int in = 0;
  int in_by_law = 0;
  double jitter_m = 0.0;  // rms at rest, the worst
  // Axial force in the last 2 mm over that of two-point contact: the ones farthest off.
  double least_force = 1e9;
  double most_force = 0.0;
};

// The device: its peg's lower end and the way that its axis leans per metre of height, both across the hole.
struct Device {
  glm::dvec2 end_m{0.0}, lean{0.0};
};

// Whitney (1982): a peg at depth l touches the bottom of one side of the hole and the top of the other, and slides in
// where it is pushed with the friction of both, F = mu (N_t + N_s). Its axis is at t at the bottom and at s at the top,
// leans by a = (s - t) / l, and its centre is at p = t + h a. Without friction across, it rests where the device's
// springs have the least energy
//   E = 1/2 k |p - p_D|^2 + 1/2 k_t |a - a_D|^2  within  |t| <= c / 2, |s| <= c / 2
// (c: diametral clearance), and N_t, N_s are the forces of these bounds: with N_t = lambda_t |t| and N_s likewise,
//   (k w_t^2 + k_t / l^2 + lambda_t) t + (k w_t w_s - k_t / l^2) s = k w_t p_D - k_t a_D / l,
//   (k w_t w_s - k_t / l^2) t + (k w_s^2 + k_t / l^2 + lambda_s) s = k w_s p_D + k_t a_D / l,
//   w_s = h / l, w_t = 1 - w_s.
// Without the spring across, k = 0, that is 2 mu k_t (|a_D| - c / l) / l.
class TwoPoints {
 public:
  TwoPoints(const scene::Coupling& coupling, const Device& device, double clearance_m, double depth_m)
      : radius_m_(0.5 * clearance_m) {
    const double k = coupling.stiffness_N_per_m, turn = coupling.stiffness_Nm_per_rad / depth_m;
    const double h = 0.5 * kLength_m, w_s = h / depth_m, w_t = 1.0 - w_s;
    tt_ = k * w_t * w_t + turn / depth_m;
    ts_ = k * w_t * w_s - turn / depth_m;
    ss_ = k * w_s * w_s + turn / depth_m;
    const glm::dvec2 p_D = device.end_m + h * device.lean;
    right_t_ = k * w_t * p_D - turn * device.lean;
    right_s_ = k * w_s * p_D + turn * device.lean;
  }

  // N_t + N_s.
  [[nodiscard]] double Sum_N() {
    lambda_s_ = Least([this](double lambda_s) {
      lambda_s_ = lambda_s;
      FindBottom();
      return glm::length(s_) <= radius_m_;
    });
    FindBottom();
    return lambda_t_ * glm::length(t_) + lambda_s_ * glm::length(s_);
  }

 private:
  void FindBottom() {
    lambda_t_ = Least([this](double lambda_t) {
      lambda_t_ = lambda_t;
      Solve();
      return glm::length(t_) <= radius_m_;
    });
    Solve();
  }
  void Solve() {
    const double tt = tt_ + lambda_t_, ss = ss_ + lambda_s_, determinant = tt * ss - ts_ * ts_;
    t_ = (ss * right_t_ - ts_ * right_s_) / determinant;
    s_ = (tt * right_s_ - ts_ * right_t_) / determinant;
  }
  // The least lambda >= 0 that holds the bound.
  template <class Holds>
  static double Least(Holds&& holds) {
    if (holds(0.0)) return 0.0;
    double low = 1.0, high = 1e9;  // [N/m]
    for (int i = 0; i < 40; ++i) {
      const double middle = std::sqrt(low * high);
      (holds(middle) ? high : low) = middle;
    }
    return high;
  }

  double radius_m_, tt_, ts_, ss_;
  glm::dvec2 right_t_, right_s_;
  double lambda_t_ = 0.0, lambda_s_ = 0.0;
  glm::dvec2 t_{0.0}, s_{0.0};
};

double TwoPointForce_N(const scene::Coupling& coupling, const Device& device, double clearance_m, double friction,
                       double depth_m) {
  return friction * TwoPoints(coupling, device, clearance_m, depth_m).Sum_N();
}

// Behind the device when it stops at the hole's depth: the deepest place where that force is the spring's.
double LagByLaw_m(const scene::Coupling& coupling, const Device& device, double clearance_m, double friction) {
  constexpr double kStep_m = 5e-5;
  double lag_m = 0.0;
  while (lag_m < 0.75 * kHole_m && coupling.stiffness_N_per_m * lag_m <
                                       TwoPointForce_N(coupling, device, clearance_m, friction, kHole_m - lag_m)) {
    lag_m += kStep_m;
  }
  return lag_m;
}

constexpr double kStart_m = 0.5 * kHole_m + 0.5 * kLength_m + 0.002;

SceneKit PegOverHole(const Variant& variant, double clearance_m, double friction) {
  SceneKit kit(variant);
  const auto block =
      kit.AddFixed(vps::MakeBlockWithHole(0.06, kHole_m, kPeg_m + 0.5 * clearance_m, kSegments), {}, 2.5e-4);
  const auto peg =
      kit.AddHand(vps::MakeCylinder(kPeg_m, kLength_m, kSegments), {{1, 0, 0, 0}, {0, 0, kStart_m}}, 16384);
  kit.AddPair(peg, block).friction = friction;
  return kit;
}

// Rms, while the device stands still.
double Jitter_m(Loop* loop, const core::Pose& X_WD) {
  for (int i = 0; i < 200; ++i) loop->Tick(X_WD);
  std::vector<glm::dvec3> places;
  glm::dvec3 mean(0.0);
  for (int i = 0; i < 200; ++i) {
    loop->Tick(X_WD);
    places.push_back(loop->X_WC().translation);
    mean += places.back() / 200.0;
  }
  double squares = 0.0;
  for (const glm::dvec3& p : places) squares += glm::dot(p - mean, p - mean) / 200.0;
  return std::sqrt(squares);
}

// The device goes straight down with an offset of the peg's lower end of up to half the clearance, so that the end is
// over the hole, and a tilt of up to 2 degrees about it.
void InsertOne(const scene::Coupling& coupling, double clearance_m, double friction, int seed, Loop* loop,
               Insertion* insertion) {
  std::mt19937_64 engine(static_cast<std::uint64_t>(seed) + 1);
  const auto unit = [&engine] { return static_cast<double>(engine() >> 11) * 0x1.0p-53; };
  const double offset = 0.5 * clearance_m * unit();
  const double to = 2.0 * std::numbers::pi * unit();
  const double tilt = kMostTilt_rad * unit();
  const double about = 2.0 * std::numbers::pi * unit();
  core::Pose X_WD;
  X_WD.rotation = core::QuaternionFromRotationVector({tilt * std::cos(about), tilt * std::sin(about), 0.0});
  const glm::dvec3 end_W(offset * std::cos(to), offset * std::sin(to), kStart_m - 0.5 * kLength_m);
  X_WD.translation = end_W + X_WD.rotate({0.0, 0.0, 0.5 * kLength_m});
  const glm::dvec3 axis_W = X_WD.rotate({0.0, 0.0, 1.0});
  const Device device{{end_W.x, end_W.y}, {axis_W.x / axis_W.z, axis_W.y / axis_W.z}};
  loop->LetGo(X_WD);
  const double end = kStart_m - 0.002 - kHole_m;
  double force_N = 0.0;
  double force_by_law_N = 0.0;
  for (; X_WD.translation.z > end; X_WD.translation.z -= 1e-3 * kSpeed_m_per_s) {
    loop->Tick(X_WD);
    if (X_WD.translation.z > end + 0.002) continue;
    const double depth_m = kStart_m - 0.002 - loop->X_WC().translation.z;
    force_N += loop->command().force_N.z;
    force_by_law_N += TwoPointForce_N(coupling, device, clearance_m, friction, std::max(depth_m, kLeast_m));
  }
  insertion->jitter_m = std::max(insertion->jitter_m, Jitter_m(loop, X_WD));
  if (loop->X_WC().translation.z < end + kIn_m) ++insertion->in;
  const double lag_m = LagByLaw_m(coupling, device, clearance_m, friction);
  if (lag_m < kIn_m) ++insertion->in_by_law;
  if (lag_m < kClearLag_m) return;
  insertion->least_force = std::min(insertion->least_force, force_N / force_by_law_N);
  insertion->most_force = std::max(insertion->most_force, force_N / force_by_law_N);
}

Insertion Insert(const Variant& variant, double clearance_m, double friction, int num_seeds) {
  const SceneKit kit = PegOverHole(variant, clearance_m, friction);
  Loop loop(kit.scenario);
  Insertion insertion;
  for (int seed = 0; seed < num_seeds; ++seed) {
    InsertOne(kit.scenario.coupling, clearance_m, friction, seed, &loop, &insertion);
  }
  return insertion;
}

struct Case {
  double clearance_m, friction;
  std::size_t variant;
  int seeds;
  Insertion insertion;
};

double Share(int count, const Case& one) {
  return 100.0 * count / one.seeds;
}

// A device that stops at the hole's depth leaves a peg with friction behind: as many are in as the law lets.
Reading ReadingOf(const Case& one) {
  const Insertion& i = one.insertion;
  const double share = Share(i.in, one);
  const std::string jitter = Short(1e6 * i.jitter_m) + " um";
  const bool is_still = i.jitter_m < 2e-6;
  if (one.friction == 0.0) {
    return {Variants()[one.variant].name, Short(share) + " %; " + jitter, share >= 99.0 && is_still};
  }
  const bool is_as_the_law = std::abs(share - Share(i.in_by_law, one)) <= 2.0;
  return {Variants()[one.variant].name,
          Short(share) + " %; " + Short(i.least_force) + " to " + Short(i.most_force) + "; " + jitter,
          is_as_the_law && i.least_force >= 0.9 && i.most_force <= 1.1 && is_still};
}

}  // namespace

double PegJitter_m(double clearance_m, double friction, int seed) {
  const SceneKit kit = PegOverHole(Variants().back(), clearance_m, friction);
  Loop loop(kit.scenario);
  Insertion insertion;
  InsertOne(kit.scenario.coupling, clearance_m, friction, seed, &loop, &insertion);
  return insertion.jitter_m;
}

void StudyPeg(Report* report) {
  std::vector<Case> cases;
  for (const double clearance_m : {1e-4, 5e-4, 2e-4, 5e-5, 2e-5}) {  // the longest first
    for (const double friction : {0.0, 0.3}) {
      for (std::size_t i = 0; i < Variants().size(); ++i)
        cases.push_back({clearance_m, friction, i, clearance_m == 1e-4 ? 100 : 20, {}});
    }
  }
  ForAll(cases.size(), [&cases](std::size_t i) {
    Case& one = cases[i];
    one.insertion = Insert(Variants()[one.variant], one.clearance_m, one.friction, one.seeds);
  });
  std::stable_sort(cases.begin(), cases.end(),
                   [](const Case& a, const Case& b) { return a.clearance_m > b.clearance_m; });

  Table table{"peg", {"contender", "clearance_mm", "friction", "seeds", "in", "jitter_um"}, {}};
  Panel panel;
  panel.title = "peg of 20 mm as the tool";
  panel.x_title = "diametral clearance [mm]";
  panel.y_title = "share that goes in [%]";
  panel.y_log = false;
  for (const Variant& variant : Variants()) panel.series.push_back({variant.name, {}, true});
  Row row;
  for (const Case& one : cases) {
    const bool has_friction = one.friction > 0.0;
    if (one.variant == 0) {
      row = {
          "F5",
          "conforming contact",
          "peg of 20 mm as the tool, clearance " + Short(1e3 * one.clearance_m) + " mm, friction " +
              Short(one.friction) + ", " + std::to_string(one.seeds) + " seeds",
          has_friction ? "share that goes in 40 mm; axial force over two-point contact's; jitter at rest"
                       : "share that goes in 40 mm; jitter at rest",
          has_friction ? Short(Share(one.insertion.in_by_law, one)) + " +- 2 %; 0.9 to 1.1; < 2 um" : ">= 99 %; < 2 um",
          {},
          "coupling `paper`: cause not looked into"};
    }
    row.readings.push_back(ReadingOf(one));
    table.Add({Variants()[one.variant].name, bench::Cell(1e3 * one.clearance_m), bench::Cell(one.friction),
               std::to_string(one.seeds), std::to_string(one.insertion.in), bench::Cell(1e6 * one.insertion.jitter_m)});
    if (!has_friction) {
      panel.series[one.variant].points.push_back({1e3 * one.clearance_m, Share(one.insertion.in, one), ""});
    }
    const bool is_bounded = one.clearance_m >= 1e-4;
    if (is_bounded && one.variant + 1 == Variants().size()) AddRow(report, row);
  }
  report->tables.push_back(table);
  report->charts.emplace_back("peg",
                              Chart{"F5: insertion by clearance",
                                    "40 mm deep at 20 mm/s, no friction; offset to half the clearance, tilt to 2 deg",
                                    {panel}});
}

}  // namespace failures
