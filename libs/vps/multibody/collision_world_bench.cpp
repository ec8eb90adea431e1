#include <benchmark/benchmark.h>

#include <cmath>

#include "vps/mesh/shapes.hpp"
#include "vps/multibody/collision_world.hpp"

namespace {

using namespace vps;

std::shared_ptr<const CookedObject> Cooked(const TriangleMesh& mesh, double voxel_size_m, std::uint32_t num_points) {
  return std::make_shared<const CookedObject>(*Cook(mesh, {voxel_size_m, num_points}));
}

// Whole step of a pair in conforming contact: peg of 16384 points in its hole, 2 mm look-ahead, planes included.
void BM_StepPegInHole(benchmark::State& state) {
  static const auto hole = Cooked(MakeBlockWithHole(0.04, 0.04, 0.01025, 96), 0.000125, 0);
  static const auto peg = Cooked(MakeCylinder(0.01, 0.04, 96), 0, 16384);
  WorldDescription description;
  description.objects = {{hole, {}}, {peg, {}}};
  description.pairs = {{.sampled = 1, .field = 0}};
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  double phase = 0.0;
  std::uint64_t tests = 0;
  for (auto _ : state) {
    phase += 0.01;
    world->SetPose(1, {{1, 0, 0, 0}, {3e-4 * std::cos(phase), 3e-4 * std::sin(phase), 0.01}});
    const StepReport& report = world->Step(&serial);
    tests += report.counters.spheres_tested + report.counters.points_tested;
  }
  state.counters["time_per_test"] =
      benchmark::Counter(static_cast<double>(tests), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_StepPegInHole)->Unit(benchmark::kMicrosecond);

// Cost of 435 pairs (30 objects) that cannot touch while all of them move.
void BM_StepApart435Pairs(benchmark::State& state) {
  static const auto part = Cooked(MakeTorus(0.05, 0.02, 48, 24), 0.001, 4096);
  WorldDescription description;
  for (std::uint16_t i = 0; i < 30; ++i) description.objects.push_back({part, {{1, 0, 0, 0}, {0.3 * i, 0, 0}}});
  for (std::uint16_t i = 0; i < 30; ++i) {
    for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
  }
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  double phase = 0.0;
  for (auto _ : state) {
    phase += 0.01;
    for (std::uint16_t i = 0; i < 30; ++i) world->SetPose(i, {{1, 0, 0, 0}, {0.3 * i, 0.01 * std::sin(phase), 0}});
    benchmark::DoNotOptimize(world->Step(&serial));
  }
}
BENCHMARK(BM_StepApart435Pairs)->Unit(benchmark::kMicrosecond);

}  // namespace
