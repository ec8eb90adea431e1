// What the jaws hold hangs on the grasp's spring in physics_node and is felt through the bus: its inertia, its momentum
// when it is let go, what friction holds, and how stiff what it touches may be.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/failures/for_all.hpp"
#include "tools/failures/gripper.hpp"
#include "tools/failures/studies/studies.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kMass_kg = 1.97;  // handle and module of `module_replacement`
constexpr double kWidth_m = 0.03;
constexpr glm::dvec3 kPart_m{kWidth_m, 0.04, 0.08};
constexpr double kAcceleration_m_per_s2 = 1.0;

core::Pose HandPose() {
  return {{1, 0, 0, 0}, {0.0, 0.0, 0.1}};
}

std::uint16_t AddHeldPart(SceneKit* kit, std::uint32_t num_points) {
  return AddHeldBox(kit, HandPose(), kPart_m, kMass_kg, 1e-3, num_points);
}

// ---- Inertia

// What a hand feels of a part that it swings: the force's fundamental F, from one fit over whole periods, against -m a.
struct Felt {
  double ratio = 0.0;   // |F| / (m |a|)
  double lag_ms = 0.0;  // of the force behind -m a
};

// The device swings along an axis; everything arrives `late_ticks` late.
Felt Wave(const glm::dvec3& axis_W, double frequency_Hz, int late_ticks) {
  SceneKit kit(Variants().back());
  AddHeldPart(&kit, 0);
  LoopOptions options;
  options.physics_delay_ticks = late_ticks;
  Loop loop(kit.scenario, options);
  Grip(&loop, HandPose(), kWidth_m);
  const double w = 2.0 * std::numbers::pi * frequency_Hz;
  constexpr double kPeriods = 4.0;  // two to come up to the amplitude, without a jerk, and two to measure
  const int num_ticks = static_cast<int>(1000.0 * kPeriods / frequency_Hz);
  double in_phase = 0.0, quadrature = 0.0;  // of the force over m, with sin(w t) and cos(w t)
  for (int i = 0; i < num_ticks; ++i) {
    const double t = 1e-3 * i;
    const double up = std::min(1.0, 2.0 * t * frequency_Hz / kPeriods);
    core::Pose X_WD = HandPose();
    const double amplitude_m = up * up * (3.0 - 2.0 * up) * kAcceleration_m_per_s2 / (w * w);
    X_WD.translation += amplitude_m * std::sin(w * t) * axis_W;
    loop.Tick(X_WD);
    if (2 * i < num_ticks) continue;
    // -m a = m kAcceleration sin(w t), and the mean of sin^2 over whole periods is 1/2.
    const double felt_m_per_s2 = glm::dot(loop.command().force_N, axis_W) / kMass_kg;
    in_phase += felt_m_per_s2 * std::sin(w * t) * 4.0 / num_ticks;
    quadrature += felt_m_per_s2 * std::cos(w * t) * 4.0 / num_ticks;
  }
  return {std::hypot(in_phase, quadrature) / kAcceleration_m_per_s2, -1e3 * std::atan2(quadrature, in_phase) / w};
}

void StudyWaving(Report* report) {
  const std::vector<double> frequencies_Hz{0.5, 1.0, 2.0};
  const std::vector<int> lates{0, 3};
  std::vector<Felt> felt(frequencies_Hz.size() * lates.size() * 3);
  ForAll(felt.size(), [&](std::size_t i) {
    glm::dvec3 axis_W(0.0);
    axis_W[static_cast<int>(i % 3)] = 1.0;
    felt[i] = Wave(axis_W, frequencies_Hz[i / 3 / lates.size()], lates[i / 3 % lates.size()]);
  });
  for (std::size_t row = 0; row < frequencies_Hz.size() * lates.size(); ++row) {
    const auto first = felt.begin() + static_cast<std::ptrdiff_t>(3 * row);
    const auto [least, most] =
        std::minmax_element(first, first + 3, [](const Felt& a, const Felt& b) { return a.ratio < b.ratio; });
    const auto latest =
        std::max_element(first, first + 3, [](const Felt& a, const Felt& b) { return a.lag_ms < b.lag_ms; });
    AddRow(report, {"H1",
                    "inertia of a held part",
                    "part of 1.97 kg swung by the hand with 1 m/s^2 at " + Short(frequencies_Hz[row / lates.size()]) +
                        " Hz along each axis, " + Short(lates[row % lates.size()]) + " ms late",
                    "amplitude of the force felt over m a; its lag",
                    "0.95 to 1.05; any",
                    {{Variants().back().name,
                      Short(least->ratio) + " to " + Short(most->ratio) + "; " + Short(latest->lag_ms) + " ms",
                      least->ratio >= 0.95 && most->ratio <= 1.05}},
                    "the part swings on the grasp's spring, which is the hand's softness"});
  }
}

// ---- Momentum

// The hand flies straight on and opens. How much of the momentum is gained or lost, relative.
double Release() {
  SceneKit kit(Variants().back());
  const auto part = AddHeldPart(&kit, 0);
  Loop loop(kit.scenario);
  core::Pose X_WD = HandPose();
  Grip(&loop, X_WD, kWidth_m);
  const glm::dvec3 v_W(0.12, 0.2, -0.1);
  constexpr int kSpeedUp_ticks = 300, kSteady_ticks = 2000, kOpen_ticks = 200;
  glm::dvec3 before(0.0);
  for (int i = 0; i < kSpeedUp_ticks + kSteady_ticks + kOpen_ticks; ++i) {
    X_WD.translation += 1e-3 * std::min(1.0, static_cast<double>(i) / kSpeedUp_ticks) * v_W;
    const int opened = i - kSpeedUp_ticks - kSteady_ticks;
    if (opened == 0) before = loop.body(part).V_WO.linear_m_per_s;
    if (opened >= 0) loop.SetOpening(kWidth_m + 1e-4 * opened);
    loop.Tick(X_WD);
  }
  if (loop.is_holding()) return 1.0;
  return glm::length(loop.body(part).V_WO.linear_m_per_s - before) / glm::length(before);
}

void StudyRelease(Report* report) {
  const double lost = Release();
  AddRow(report, {"H2",
                  "letting go",
                  "part of 1.97 kg let go by a hand that flies straight on at 0.25 m/s",
                  "momentum gained or lost, of it all",
                  "<= 1e-9",
                  {{Variants().back().name, Short(lost), lost <= 1e-9}},
                  "the jaws push on the part while they open"});
}

// ---- Grip by friction

struct Gripped {
  double slip_m = 0.0;        // in ten seconds with a tenth more than the weight needs
  double acceleration = 0.0;  // with half of what it needs, over half of g
};

// A part of 0.5 kg stands on a table, is lifted and held; then the jaws open a little.
Gripped HoldByFriction() {
  constexpr double kHeld_kg = 0.5, kG = 9.81;
  SceneKit kit(Variants().back());
  kit.scenario.gravity_m_per_s2 = {0.0, 0.0, -kG};
  kit.scenario.coupling.is_grip_by_friction = true;
  core::Pose X_WD{{1, 0, 0, 0}, {0.0, 0.0, kPart_m.z - kHeldTop_m}};
  const auto table = kit.AddFixed(vps::MakeBox({0.2, 0.2, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, 1e-3);
  const auto part = AddHeldBox(&kit, X_WD, kPart_m, kHeld_kg, 1e-3, 4096);
  kit.AddPair(part, table);
  // Each jaw holds mu k d of the weight.
  const scene::Coupling& coupling = kit.scenario.coupling;
  const double weight_m = kHeld_kg * kG / (2.0 * scene::Pair{}.friction * coupling.jaw_stiffness_N_per_m);
  Loop loop(kit.scenario);
  Grip(&loop, X_WD, kWidth_m, 1.1 * weight_m);
  constexpr double kUp_m = 0.02;
  constexpr int kUp_ticks = 1000, kHold_ticks = 10000, kSlip_ticks = 60, kFirst_ticks = 10;
  for (int i = 0; i < kUp_ticks; ++i) {
    const double t = static_cast<double>(i + 1) / kUp_ticks;
    X_WD.translation.z = kPart_m.z - kHeldTop_m + kUp_m * t * t * (3.0 - 2.0 * t);
    loop.Tick(X_WD);
  }
  Gripped gripped;
  for (int i = 0; i < kUp_ticks; ++i) loop.Tick(X_WD);
  const double up_m = loop.body(part).X_WO.translation.z;
  for (int i = 0; i < kHold_ticks; ++i) loop.Tick(X_WD);
  gripped.slip_m = up_m - loop.body(part).X_WO.translation.z;
  if (!loop.is_holding() || up_m - X_WD.translation.z < -0.5 * kUp_m) gripped.slip_m = 1.0;  // it stayed on the table
  loop.SetOpening(kWidth_m - 2.0 * 0.5 * weight_m);
  double before = 0.0;
  for (int i = 0; i < kSlip_ticks; ++i) {
    loop.Tick(X_WD);
    if (i + 1 == kFirst_ticks) before = loop.body(part).V_WO.linear_m_per_s.z;
  }
  const double gained = before - loop.body(part).V_WO.linear_m_per_s.z;
  gripped.acceleration = gained / (1e-3 * (kSlip_ticks - kFirst_ticks)) / (0.5 * kG);
  return gripped;
}

void StudyGrip(Report* report) {
  const Gripped gripped = HoldByFriction();
  AddRow(report, {"H3",
                  "grip by friction",
                  "part of 0.5 kg lifted under 1 g, the jaws' friction 1.1 times the weight for 10 s, then half of it",
                  "slip in the 10 s; acceleration over g / 2",
                  "<= 10 um; 0.95 to 1.05",
                  {{Variants().back().name, Short(1e6 * gripped.slip_m) + " um; " + Short(gripped.acceleration),
                    gripped.slip_m <= 1e-5 && gripped.acceleration >= 0.95 && gripped.acceleration <= 1.05}},
                  ""});
}

// ---- Stiffness of what a held part touches

constexpr double kRest_m = 1e-6;  // rms of the part at rest, more is a limit cycle
constexpr double kMostActing = 0.01;

bool IsQuiet(double pair_N_per_m, double grasp_N_per_m, int late_ticks) {
  SceneKit kit(Variants().back());
  // A stiffer grasp with the same share of damping.
  const double scale = grasp_N_per_m / kit.scenario.coupling.grasp_stiffness_N_per_m;
  kit.scenario.coupling.grasp_stiffness_N_per_m *= scale;
  kit.scenario.coupling.grasp_stiffness_Nm_per_rad *= scale;
  kit.scenario.coupling.grasp_damping_N_s_per_m *= std::sqrt(scale);
  kit.scenario.coupling.grasp_damping_Nm_s_per_rad *= std::sqrt(scale);
  const auto plate = kit.AddFixed(vps::MakeBox({0.2, 0.2, 0.02}), {{1, 0, 0, 0}, {0, 0, -0.01}}, 1e-3);
  const auto part = AddHeldPart(&kit, 8000);
  kit.AddPair(part, plate).stiffness_N_per_m = pair_N_per_m;
  LoopOptions options;
  options.command_delay_ticks = options.physics_delay_ticks = late_ticks;
  options.script = "grip 0.0298 force 30\nwait until held " + kit.scenario.objects[part].name +
                   "\npush 0 0 -1 by 0.1 speed 0.05 until felt 10\nwait 100\n";
  Loop loop(kit.scenario, options);
  for (int i = 0; i < 5000 && !loop.is_holding(); ++i) loop.Tick();
  if (!loop.is_holding()) throw std::runtime_error("the operator does not get hold of the part");
  loop.Run(2.0);  // until it is on the plate
  const std::uint64_t before = loop.bridge().figures(0).samples_made_passive;
  loop.Run(6.0);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < 1000; ++i) {
    loop.Tick();
    places.push_back(loop.body(part).X_WO.translation);
  }
  const auto acted = static_cast<double>(loop.bridge().figures(0).samples_made_passive - before);
  return Spread(places) <= kRest_m && acted < kMostActing * 7000.0;
}

template <class Quiet>
double LargestQuiet(const std::vector<double>& candidates, Quiet&& is_quiet) {
  double largest = 0.0;
  for (const double one : candidates) {
    if (!is_quiet(one)) break;
    largest = one;
  }
  return largest;
}

void StudyStiffness(Report* report) {
  const double grasp_N_per_m = scene::Coupling{}.grasp_stiffness_N_per_m;
  constexpr double kPair_N_per_m = 1e5;
  const std::vector<int> lates{0, 3};
  std::vector<double> pair(lates.size()), grasp(lates.size());
  ForAll(2 * lates.size(), [&](std::size_t i) {
    const int late = lates[i / 2];
    if (i % 2 == 0) {
      pair[i / 2] = LargestQuiet({2e4, 6e4, 2e5, 1e6, 1e7}, [&](double k) { return IsQuiet(k, grasp_N_per_m, late); });
    } else {
      grasp[i / 2] = LargestQuiet({3e3, 5e3, 8e3, 1.2e4, 2e4, 3e4, 5e4, 8e4},
                                  [&](double k) { return IsQuiet(kPair_N_per_m, k, late); });
    }
  });
  for (std::size_t i = 0; i < lates.size(); ++i) {
    const std::string late =
        Short(0.3 + lates[i]) + " ms late to the device, " + Short(lates[i]) + " ms to physics_node";
    AddRow(report, {"H4",
                    "stiffness that a held part touches",
                    "part of 1.97 kg in the hand, pressed on a plate with 10 N, " + late,
                    "largest stiffness of the pair with the part at rest and the controller in < 1 % of cycles, of "
                    "those up to 10 MN/m",
                    ">= 60 kN/m",
                    {{Variants().back().name, Short(1e-3 * pair[i]) + " kN/m", pair[i] >= 6e4}},
                    ""});
    AddRow(report, {"H4",
                    "stiffness that a held part touches",
                    "the same on a pair of 100 kN/m, with stiffer grasps, " + late,
                    "largest stiffness of the grasp, which is what the hand feels of the wall",
                    ">= " + Short(1e-3 * grasp_N_per_m) + " kN/m, which is shipped",
                    {{Variants().back().name, Short(1e-3 * grasp[i]) + " kN/m", grasp[i] >= grasp_N_per_m}},
                    ""});
  }
}

}  // namespace

void StudyHeld(Report* report) {
  StudyWaving(report);
  StudyRelease(report);
  StudyGrip(report);
  StudyStiffness(report);
}

}  // namespace failures
