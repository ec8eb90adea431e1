// F5 with a peg that jaws hold: physics_node moves it on the grasp's spring.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tools/failures/for_all.hpp"
#include "tools/failures/gripper.hpp"
#include "tools/failures/studies/studies.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kPeg_m = 0.01;  // radius
constexpr double kLength_m = 0.1;
constexpr double kHole_m = 0.04;                   // its depth
constexpr double kEnd_m = kHeldTop_m - kLength_m;  // of the peg, in the palm's z
constexpr double kAbove_m = 0.002;                 // of the peg's end, at the start
constexpr double kStep_m = 2e-5;                   // in a tick: 20 mm/s
constexpr double kMostTilt_rad = 2.0 * std::numbers::pi / 180.0;
constexpr double kIn_m = 0.001;  // behind the device
constexpr int kSegments = 128;

struct HeldPeg {
  SceneKit kit{Variants().back()};
  std::uint16_t peg = 0;
};

HeldPeg PegOverHole(const core::Pose& X_WD, double clearance_m, double friction) {
  HeldPeg scene;
  const auto hole = vps::MakeBlockWithHole(0.06, kHole_m, kPeg_m + 0.5 * clearance_m, kSegments);
  const auto block = scene.kit.AddFixed(hole, {}, 2.5e-4);
  AddGripper(&scene.kit, X_WD, 2.0 * kPeg_m);
  vps::TriangleMesh mesh = vps::MakeCylinder(kPeg_m, kLength_m, kSegments);
  for (glm::dvec3& vertex : mesh.vertices) vertex.z += kEnd_m + 0.5 * kLength_m;
  scene.peg = scene.kit.AddBody(mesh, X_WD, 0.25, 5e-4, 24000);
  AddGripPairs(&scene.kit, scene.peg);
  scene.kit.AddPair(scene.peg, block).friction = friction;
  return scene;
}

// The peg's end at `end_W`, leaning about it by a rotation vector across z.
core::Pose HandPose(const glm::dvec3& end_W, const glm::dvec2& lean_rad) {
  core::Pose X_WD;
  X_WD.rotation = core::QuaternionFromRotationVector({lean_rad.x, lean_rad.y, 0.0});
  X_WD.translation = end_W - X_WD.rotate({0.0, 0.0, kEnd_m});
  return X_WD;
}

struct Inserted {
  bool is_in = false;
  double jitter_m = 0.0;
};

// The end is off the hole's middle by up to half the clearance; the peg leans by up to 2 degrees.
Inserted Insert(double clearance_m, double friction, std::size_t seed) {
  std::mt19937_64 engine(seed + 1);
  const auto unit = [&engine] { return static_cast<double>(engine() >> 11) * 0x1.0p-53; };
  const double offset_m = 0.5 * clearance_m * unit(), to = 2.0 * std::numbers::pi * unit();
  const double lean = kMostTilt_rad * unit(), about = 2.0 * std::numbers::pi * unit();
  core::Pose X_WD = HandPose({offset_m * std::cos(to), offset_m * std::sin(to), 0.5 * kHole_m + kAbove_m},
                             lean * glm::dvec2(std::cos(about), std::sin(about)));
  const HeldPeg scene = PegOverHole(X_WD, clearance_m, friction);
  Loop loop(scene.kit.scenario);
  Grip(&loop, X_WD, 2.0 * kPeg_m);
  const int num_ticks = static_cast<int>(std::lround((kAbove_m + kHole_m) / kStep_m));
  for (int i = 0; i < num_ticks; ++i) {
    X_WD.translation.z -= kStep_m;
    loop.Tick(X_WD);
  }
  for (int i = 0; i < 300; ++i) loop.Tick(X_WD);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < 200; ++i) {
    loop.Tick(X_WD);
    places.push_back(loop.body(scene.peg).X_WO.translation);
  }
  return {loop.is_holding() && places.back().z - X_WD.translation.z < kIn_m, Spread(places)};
}

void StudyInsertion(Report* report) {
  struct Case {
    double clearance_m, friction;
    std::vector<Inserted> inserted;
  };
  constexpr std::size_t kSeeds = 100;
  std::vector<Case> cases{{1e-4, 0.0, {}}, {5e-5, 0.0, {}}, {1e-4, 0.15, {}}, {5e-5, 0.15, {}}};
  for (Case& one : cases) one.inserted.resize(kSeeds);
  ForAll(cases.size() * kSeeds, [&cases](std::size_t i) {
    Case& one = cases[i / kSeeds];
    one.inserted[i % kSeeds] = Insert(one.clearance_m, one.friction, i % kSeeds);
  });
  for (const Case& one : cases) {
    const auto in = std::count_if(one.inserted.begin(), one.inserted.end(), [](const Inserted& i) { return i.is_in; });
    double jitter_m = 0.0;
    for (const Inserted& i : one.inserted) jitter_m = std::max(jitter_m, i.jitter_m);
    AddRow(report, {"F5",
                    "conforming contact",
                    "peg of 20 mm held by jaws, clearance " + Short(1e3 * one.clearance_m) + " mm, friction " +
                        Short(one.friction) + ", " + std::to_string(kSeeds) + " seeds",
                    "share that goes in 40 mm; jitter at rest",
                    ">= 99 %; < 2 um",
                    {{Variants().back().name,
                      Short(100.0 * static_cast<double>(in) / kSeeds) + " %; " + Short(1e6 * jitter_m) + " um",
                      in >= 99 && jitter_m < 2e-6}},
                    "a peg that leans is held by the friction of two places"});
  }
}

// At depth l a peg with diametral clearance c touches at two places from the angle c / l on [Whitney 1982]. The device
// leans slowly about the middle of what is in the hole, so that both are reached at once. The contacts give, so the
// angle is taken when they take the first moment.
double WedgingAngle(double clearance_m, double depth_m) {
  core::Pose X_WD = HandPose({0.0, 0.0, 0.5 * kHole_m + kAbove_m}, {0.0, 0.0});
  const HeldPeg scene = PegOverHole(X_WD, clearance_m, 0.0);
  Loop loop(scene.kit.scenario);
  Grip(&loop, X_WD, 2.0 * kPeg_m);
  const int num_ticks = static_cast<int>(std::lround((kAbove_m + depth_m) / kStep_m));
  for (int i = 0; i < num_ticks; ++i) {
    X_WD.translation.z -= kStep_m;
    loop.Tick(X_WD);
  }
  const glm::dvec3 middle_W(0.0, 0.0, 0.5 * kHole_m - 0.5 * depth_m);
  const glm::dvec3 p_WD = X_WD.translation;
  constexpr double kFirst_Nm = 1e-6;  // before there is none but rounding's, 1e-15
  constexpr double kRate_rad = 5e-7;  // in a tick
  const auto moment_Nm = [&] {
    const core::Wrench& F = loop.command();
    return F.torque_Nm + glm::cross(X_WD.translation - middle_W, F.force_N);
  };
  for (int i = 0; i < 500; ++i) loop.Tick(X_WD);
  const glm::dvec3 upright_Nm = moment_Nm();
  double angle = 0.0;
  for (int i = 0; i < static_cast<int>(3.0 * clearance_m / depth_m / kRate_rad); ++i) {
    X_WD.rotation = core::QuaternionFromRotationVector({kRate_rad * i, 0.0, 0.0});
    X_WD.translation = middle_W + X_WD.rotate(p_WD - middle_W);
    loop.Tick(X_WD);
    angle = std::acos(std::min(1.0, loop.body(scene.peg).X_WO.rotate({0.0, 0.0, 1.0}).z));
    // The first half of the way lets the jerk of the start die away.
    if (kRate_rad * i < 0.5 * clearance_m / depth_m) continue;
    if (glm::length(moment_Nm() - upright_Nm) > kFirst_Nm) break;
  }
  return angle;
}

void StudyWedging(Report* report) {
  for (const double clearance_m : {1e-4, 5e-5}) {
    const std::vector<double> depths_m{0.01, 0.02, 0.03};
    std::vector<double> ratios(depths_m.size());
    ForAll(ratios.size(),
           [&](std::size_t i) { ratios[i] = WedgingAngle(clearance_m, depths_m[i]) * depths_m[i] / clearance_m; });
    const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
    AddRow(report, {"F5",
                    "conforming contact",
                    "peg of 20 mm held by jaws, clearance " + Short(1e3 * clearance_m) + " mm, 10 to 30 mm deep, leant",
                    "angle at which it wedges over the two-point formula's",
                    "0.9 to 1.1",
                    {{Variants().back().name, Short(*least) + " to " + Short(*most), *least >= 0.9 && *most <= 1.1}},
                    "the contacts give by the force that it takes to lean the peg"});
  }
}

}  // namespace

void StudyHeldPeg(Report* report) {
  StudyInsertion(report);
  StudyWedging(report);
}

}  // namespace failures
