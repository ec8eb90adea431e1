// F10, F14, F19 and F20 with parts that jaws hold, or that nothing holds but what is around them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/failures/for_all.hpp"
#include "tools/failures/gripper.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/thread_mesh.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kWidth_m = 0.03;

core::Pose At(double z_m) {
  return {{1, 0, 0, 0}, {0.0, 0.0, z_m}};
}

// ---- F10: a heavy part in the hand presses a light one on a table.

struct Squeezed {
  double overlap_m = 0.0;
  double step_us = 0.0;  // of physics_node, mean, processor time
};

Squeezed PressLightPart() {
  constexpr double kHeight_m = 0.005;  // of the light part
  constexpr double kAbove_m = 0.0005;
  constexpr double kStiffness_N_per_m = 1e6;  // 10 um at 10 N: stiff for 2 g at 1 kHz, k T^2 / m = 500
  SceneKit kit(Variants().back());
  const auto table = kit.AddFixed(vps::MakeBox({0.2, 0.2, 0.02}), At(-0.01), kVoxel_m);
  core::Pose X_WD = At(kHeight_m + kAbove_m + 0.08 - kHeldTop_m);
  const auto heavy = AddHeldBox(&kit, X_WD, {kWidth_m, 0.04, 0.08}, 2.0, kVoxel_m, 4096);
  const auto light = kit.AddBody(vps::MakeBox({0.05, 0.05, kHeight_m}), At(0.5 * kHeight_m), 0.002, kVoxel_m, 4096);
  kit.AddPair(heavy, light).stiffness_N_per_m = kStiffness_N_per_m;
  kit.AddPair(light, table).stiffness_N_per_m = kStiffness_N_per_m;
  Loop loop(kit.scenario);
  Grip(&loop, X_WD, kWidth_m);
  // As deep as the grasp's spring is long at 10 N.
  const double down_m = kAbove_m + 10.0 / kit.scenario.coupling.grasp_stiffness_N_per_m;
  constexpr int kDown_ticks = 1000, kRest_ticks = 1000;
  Squeezed squeezed;
  for (int i = 0; i < kDown_ticks + kRest_ticks; ++i) {
    X_WD.translation.z -= i < kDown_ticks ? down_m / kDown_ticks : 0.0;
    loop.Tick(X_WD);
    if (i < kDown_ticks) continue;
    const double z_m = loop.body(light).X_WO.translation.z;
    const double bottom_m = (loop.body(heavy).X_WO * glm::dvec3(0.0, 0.0, kHeldTop_m - 0.08)).z;
    squeezed.overlap_m = std::max({squeezed.overlap_m, 0.5 * kHeight_m - z_m, z_m + 0.5 * kHeight_m - bottom_m});
    squeezed.step_us += 1e-3 * static_cast<double>(loop.physics_cpu_ns()) / kRest_ticks;
  }
  if (loop.command().force_N.z < 5.0) throw std::runtime_error("the heavy part does not press");
  return squeezed;
}

void StudyHandHeldMassRatio(Report* report) {
  const Squeezed squeezed = PressLightPart();
  AddRow(report, {"F10",
                  "mass ratio",
                  "part of 2 kg in the hand presses one of 2 g on a table with 10 N, pairs of 1 MN/m",
                  "overlap; time of physics' step",
                  "<= 50 um; <= 0.2 ms",
                  {{Variants().back().name, Short(1e6 * squeezed.overlap_m) + " um; " + Short(squeezed.step_us) + " us",
                    squeezed.overlap_m <= 5e-5 && squeezed.step_us <= 200.0}},
                  ""});
}

// ---- F14: a cube with weight between six spikes, one at the middle of each face, with a little play.

struct Caged {
  double away_m = 0.0;     // farthest of its middle
  double rocking_m = 0.0;  // rms of a corner in the last half
};

Caged Cage() {
  constexpr double kCube_m = 0.02, kSpike_m = 0.01, kPlay_m = 2e-5;
  SceneKit kit(Variants().back());
  kit.AddIdleHand();
  kit.scenario.gravity_m_per_s2 = 9.81 * glm::normalize(glm::dvec3(1.0, -2.0, -3.0));
  const auto cube = kit.AddBody(vps::MakeBox(glm::dvec3(kCube_m)), {}, 0.06, 2.5e-4, 4096);
  const vps::TriangleMesh spike = vps::MakeCylinder(2.5e-4, kSpike_m, 16);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      core::Pose X_WS;
      X_WS.translation[axis] = side * (0.5 * kCube_m + kPlay_m + 0.5 * kSpike_m);
      glm::dvec3 turn(0.0);
      if (axis < 2) turn[1 - axis] = 0.5 * std::numbers::pi;
      X_WS.rotation = core::QuaternionFromRotationVector(turn);
      kit.AddPair(kit.AddFixed(spike, X_WS, 0.0, 512), cube).friction = 0.3;
    }
  }
  Loop loop(kit.scenario);
  const std::vector<core::Pose> idle{kit.device().X_WD_start};
  Caged caged;
  std::vector<glm::dvec3> corners;
  for (int i = 0; i < 10000; ++i) {
    loop.Tick(idle);
    const core::Pose& X_WO = loop.body(cube).X_WO;
    caged.away_m = std::max(caged.away_m, glm::length(X_WO.translation));
    if (i >= 5000) corners.push_back(X_WO * glm::dvec3(0.5 * kCube_m));
  }
  caged.rocking_m = Spread(corners);
  return caged;
}

void StudyCage(Report* report) {
  const Caged caged = Cage();
  AddRow(report, {"F14",
                  "redundant contacts",
                  "cube of 20 mm and 60 g between six spikes of 0.5 mm with 0.02 mm of play, 1 g askew, 10 s",
                  "farthest of its middle; rocking",
                  "<= 0.2 mm; <= 5 um",
                  {{Variants().back().name, Short(1e3 * caged.away_m) + " mm; " + Short(1e6 * caged.rocking_m) + " um",
                    caged.away_m <= 2e-4 && caged.rocking_m <= 5e-6}},
                  ""});
}

// ---- F19: a handle in the hand, pressed into the corner of a slot.

struct Jitter {
  double pose_m = 0.0;
  double force = 0.0;  // of its mean
};

Jitter RestInSlot() {
  SceneKit kit(Variants().back());
  const vps::TriangleMesh wall = vps::MakeBox({0.08, 0.02, 0.04});
  const core::Pose X_WD = At(0.0005 + 0.09 - kHeldTop_m);
  const auto floor = kit.AddFixed(vps::MakeBox({0.1, 0.1, 0.02}), At(-0.01), 5e-4);
  const auto left = kit.AddFixed(wall, {{1, 0, 0, 0}, {0.0, -0.0201, 0.02}}, 5e-4);
  const auto right = kit.AddFixed(wall, {{1, 0, 0, 0}, {0.0, 0.0201, 0.02}}, 5e-4);
  // Nothing but the handle is in the slot: the jaws hold it above the walls.
  const auto handle = AddHeldBox(&kit, X_WD, {0.06, 0.02, 0.09}, 0.22, kVoxel_m, 8192);
  for (const auto field : {floor, left, right}) kit.AddPair(handle, field);
  LoopOptions options;
  options.script = "grip 0.0598 force 30\nwait until held " + kit.scenario.objects[handle].name +
                   "\npush 0 0.5 -0.8660254 by 0.012 speed 0.02\nwait 600";
  Loop loop(kit.scenario, options);
  loop.Run(8.0);
  if (!loop.is_holding()) throw std::runtime_error("the operator does not get hold of the handle");
  std::vector<glm::dvec3> places, forces;
  glm::dvec3 mean_N(0.0);
  for (int i = 0; i < 10000; ++i) {
    loop.Tick();
    places.push_back(loop.body(handle).X_WO.translation);
    forces.push_back(loop.exerted().force_N);
    mean_N += forces.back() / 10000.0;
  }
  return {Spread(places), Spread(forces) / glm::length(mean_N)};
}

void StudyHeldRest(Report* report) {
  const Jitter jitter = RestInSlot();
  AddRow(report, {"F19",
                  "jitter at rest",
                  "handle of 0.22 kg in the hand, pressed into the corner of a slot 0.2 mm wider for 10 s, no tremor",
                  "rms of its place; of the force",
                  "<= 1 um; <= 0.5 %",
                  {{Variants().back().name, Short(1e6 * jitter.pose_m) + " um; " + Short(100.0 * jitter.force) + " %",
                    jitter.pose_m <= 1e-6 && jitter.force <= 0.005}},
                  ""});
}

// ---- F20: a nut in the jaws is driven on a bolt.

struct Driven {
  double pitch_error = 0.0;  // of the advance over all turns
  int skipped = 0;           // threads, when turned and when hammered
  bool is_held = false;
};

Driven DriveNut(const ThreadFit& size) {
  constexpr int kTurns = 4, kHits = 2000, kHit_ticks = 60;
  // The hand goes from one blow to the next in this time: at once, the grasp's damper alone would hit with 700 N.
  constexpr int kSwing_ticks = 40;
  constexpr double kTurns_per_s = 1.0, kLoad_N = 10.0, kBlow_N = 25.0;
  constexpr double kNutInHand_m = -0.03;  // in the palm's z
  SceneKit kit(Variants().back());
  const double pitch_m = size.thread.pitch_m, outer_m = 1.5 * size.thread.major_m;
  const auto bolt = kit.AddFixed(MakeBolt(size.thread, 16.0 * pitch_m), {}, 2.5e-4);
  double turns = -0.5 * kTurns;
  core::Pose X_WD = At(turns * pitch_m - kNutInHand_m);
  AddGripper(&kit, X_WD, 2.0 * outer_m);
  const auto nut =
      kit.AddBody(MakeNut(size.thread, size.gap_m, outer_m, 4.0 * pitch_m), At(turns * pitch_m), 0.03, 2.5e-4, 16384);
  AddGripPairs(&kit, nut);
  scene::Pair& pair = kit.AddPair(nut, bolt);
  pair.friction = 0.1;
  pair.stiffness_N_per_m = 1e6;  // at the usual 20 kN/m a hit presses the threads through each other: 1.25 mm
  Loop loop(kit.scenario);
  Grip(&loop, X_WD, 2.0 * outer_m);
  Driven driven;
  const auto tick = [&](double force_N) {
    X_WD.translation.z = turns * pitch_m - kNutInHand_m - force_N / kit.scenario.coupling.grasp_stiffness_N_per_m;
    const double angle = 2.0 * std::numbers::pi * std::remainder(turns, 1.0);
    X_WD.rotation = core::QuaternionFromRotationVector({0.0, 0.0, angle});
    loop.Tick(X_WD);
    const double off = loop.body(nut).X_WO.translation.z / pitch_m - turns;
    driven.skipped = std::max(driven.skipped, static_cast<int>(std::lround(std::abs(off))));
  };
  for (int i = 0; i < 300; ++i) tick(kLoad_N * i / 300.0);
  const double step = 1e-3 * kTurns_per_s;
  const int num_steps = static_cast<int>(std::lround(kTurns / step));
  double first_m = 0.0;
  for (int i = 1; i <= num_steps; ++i) {
    turns = -0.5 * kTurns + step * i;
    tick(kLoad_N);
    if (i == num_steps / kTurns) first_m = loop.body(nut).X_WO.translation.z;  // after a turn of settling
  }
  const double exact_m = (kTurns - 1) * pitch_m;
  driven.pitch_error = std::abs(loop.body(nut).X_WO.translation.z - first_m - exact_m) / exact_m;
  for (int i = 0; i < kHits * kHit_ticks; ++i) {
    const double swung = std::min(1.0, static_cast<double>(i % kHit_ticks) / kSwing_ticks);
    tick((i / kHit_ticks % 2 == 0 ? 1.0 : -1.0) * (2.0 * swung - 1.0) * kBlow_N);
  }
  driven.is_held = loop.is_holding();
  return driven;
}

void StudyHeldNut(Report* report) {
  std::vector<Driven> driven(std::size(kThreadFits));
  ForAll(driven.size(), [&driven](std::size_t i) { driven[i] = DriveNut(kThreadFits[i]); });
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const Driven& one = driven[i];
    AddRow(report,
           {"F20",
            "threads",
            std::string("nut held by jaws on a fixed bolt, ") + kThreadFits[i].name +
                ", pair of 1 MN/m, 4 turns at 1 rev/s against 10 N, 2000 hits of 25 N",
            "pitch error; skipped threads",
            "<= 2 %; 0",
            {{Variants().back().name,
              Short(100.0 * one.pitch_error) + " %; " + std::to_string(one.skipped) + (one.is_held ? "" : ", lost"),
              one.pitch_error <= 0.02 && one.skipped == 0 && one.is_held}},
            ""});
  }
}

}  // namespace

void StudyHeldBodies(Report* report) {
  StudyHandHeldMassRatio(report);
  StudyCage(report);
  StudyHeldRest(report);
  StudyHeldNut(report);
}

}  // namespace failures
