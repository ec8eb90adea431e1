// F20: a nut as the hand's tool on a bolt. It is turned against a load along the axis, which only the thread moves;
// then it is hammered to and fro.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/thread_mesh.hpp"
#include "tools/failures/tool_on_plate.hpp"

namespace failures {
namespace {

constexpr double kTurns_per_s = 1.0;
constexpr int kTurns = 4;
constexpr double kLoad_m = 0.004;  // of the device behind the nut: 10 N at 2500 N/m
constexpr double kBlow_m = 0.010;  // of the device, up and down: 25 N
constexpr int kHits = 2000;
constexpr int kHit_ticks = 10;

struct Driven {
  double pitch_error = 0.0;  // of the advance over all turns
  int skipped = 0;           // threads, when turned and when hammered
};

Driven Drive(const Variant& variant, const ThreadFit& size) {
  SceneKit kit(variant);
  const auto bolt = kit.AddFixed(MakeBolt(size.thread, 16.0 * size.thread.pitch_m), {}, 2.5e-4);
  const vps::TriangleMesh mesh = MakeNut(size.thread, size.gap_m, 1.5 * size.thread.major_m, 4.0 * size.thread.pitch_m);
  const auto nut = kit.AddHand(mesh, {}, 16384);
  kit.AddPair(nut, bolt).friction = 0.1;
  Loop loop(kit.scenario);
  Driven driven;
  double turns = -0.5 * kTurns;
  core::Pose X_WD{{1, 0, 0, 0}, {0.0, 0.0, turns * size.thread.pitch_m}};
  loop.LetGo(X_WD);
  const auto tick = [&] {
    loop.Tick(X_WD);
    const double off = loop.X_WC().translation.z / size.thread.pitch_m - turns;
    driven.skipped = std::max(driven.skipped, static_cast<int>(std::lround(std::abs(off))));
  };
  const auto turn_to = [&](double to) {
    turns = to;
    const double angle = 2.0 * std::numbers::pi * std::remainder(turns, 1.0);
    X_WD.rotation = core::QuaternionFromRotationVector({0.0, 0.0, angle});
    X_WD.translation.z = turns * size.thread.pitch_m - kLoad_m;
    tick();
  };
  for (int i = 0; i < 300; ++i) {  // the load comes on
    X_WD.translation.z = turns * size.thread.pitch_m - kLoad_m * i / 300.0;
    tick();
  }
  const double step = 1e-3 * kTurns_per_s;
  const int num_steps = static_cast<int>(std::lround(kTurns / step));
  double first_m = 0.0;
  for (int i = 1; i <= num_steps; ++i) {
    turn_to(-0.5 * kTurns + step * i);
    if (i == num_steps / kTurns) first_m = loop.X_WC().translation.z;  // after a turn of settling
  }
  const double exact_m = (kTurns - 1) * size.thread.pitch_m;
  driven.pitch_error = std::abs(loop.X_WC().translation.z - first_m - exact_m) / exact_m;
  const double middle_m = turns * size.thread.pitch_m;
  for (int i = 0; i < kHits * kHit_ticks; ++i) {
    X_WD.translation.z = middle_m + ((i / kHit_ticks) % 2 == 0 ? kBlow_m : -kBlow_m);
    tick();
  }
  return driven;
}

}  // namespace

void StudyThreads(Report* report) {
  std::vector<Driven> driven(std::size(kThreadFits) * Variants().size());
  ForAll(driven.size(), [&driven](std::size_t i) {
    driven[i] = Drive(Variants()[i % Variants().size()], kThreadFits[i / Variants().size()]);
  });
  for (std::size_t s = 0; s < std::size(kThreadFits); ++s) {
    Row row{"F20",
            "threads",
            std::string("nut as the tool on a fixed bolt, ") + kThreadFits[s].name +
                ", 4 turns at 1 rev/s against 10 N, 2000 hits of 25 N",
            "pitch error; skipped threads",
            "<= 2 %; 0",
            {},
            "god object: the nut is off by a thread; the cause has not been found"};
    for (std::size_t v = 0; v < Variants().size(); ++v) {
      const Driven& one = driven[s * Variants().size() + v];
      row.readings.push_back({Variants()[v].name, Short(100.0 * one.pitch_error) + " %; " + std::to_string(one.skipped),
                              one.pitch_error <= 0.02 && one.skipped == 0});
    }
    AddRow(report, row);
  }
}

}  // namespace failures
