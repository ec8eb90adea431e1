#include <benchmark/benchmark.h>

#include <memory>
#include <random>

#include "vps/query/tree_query.hpp"
#include "vps/testing/brute_force.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

// Time per query and, as "ns_per_test", per sphere or point test [VR-OOS, Fig. 6].
namespace {

using namespace vps;

struct Scene {
  Voxmap field;
  PointTree points;
  QueryScratch scratch{PointTree{}};
  std::vector<core::Pose> poses;
};

// Conforming: a 20 mm peg, 60 mm long, in a hole with 0.5 mm diametral clearance, shifted and tilted a little.
const Scene& Conforming() {
  static const std::unique_ptr<Scene> scene = [] {
    auto s = std::make_unique<Scene>();
    s->field = *BuildVoxmap(MakeBlockWithHole(0.05, 0.05, 0.01025, 128), 0.000125 * 2);
    s->points = BuildTree(*BuildPointshell(MakeCylinder(0.01, 0.06, 128), 65536));
    s->scratch = QueryScratch(s->points);
    std::mt19937_64 random(1);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
    for (int i = 0; i < 64; ++i) {
      core::Pose X;
      X.translation = {3e-4 * uniform(), 3e-4 * uniform(), 5e-3 * uniform()};
      X.rotation = core::QuaternionFromRotationVector({5e-3 * uniform(), 5e-3 * uniform(), 3.0 * uniform()});
      s->poses.push_back(X);
    }
    return s;
  }();
  return *scene;
}

// Light: a torus that touches the outside of another at about one place, 0.5 mm deep.
const Scene& Light() {
  static const std::unique_ptr<Scene> scene = [] {
    auto s = std::make_unique<Scene>();
    s->field = *BuildVoxmap(MakeTorus(0.1, 0.04, 256, 128), 0.001);
    s->points = BuildTree(*BuildPointshell(MakeTorus(0.05, 0.02, 256, 128), 65536));
    s->scratch = QueryScratch(s->points);
    std::mt19937_64 random(1);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
    for (int i = 0; i < 64; ++i) {
      core::Pose X;
      const double angle = 3.1 * uniform();
      X.translation = 0.2095 * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
      X.rotation = core::QuaternionFromRotationVector({0.0, 0.0, 3.0 * uniform()});
      s->poses.push_back(X);
    }
    return s;
  }();
  return *scene;
}

void RunTree(benchmark::State& state, const Scene& scene, double margin_m) {
  QueryScratch scratch(scene.points);
  std::uint64_t spheres = 0, points = 0, colliding = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const QueryResult r =
        QueryTree(scene.points, scene.field, scene.poses[i++ % scene.poses.size()], margin_m, &scratch);
    spheres += r.spheres_tested;
    points += r.points_tested;
    colliding += r.num_colliding;
    benchmark::DoNotOptimize(r);
  }
  const double n = static_cast<double>(state.iterations());
  state.counters["spheres"] = static_cast<double>(spheres) / n;
  state.counters["points"] = static_cast<double>(points) / n;
  state.counters["colliding"] = static_cast<double>(colliding) / n;
  // Inverted rate: seconds per test, shown with the unit's prefix (n = ns).
  state.counters["time_per_test"] = benchmark::Counter(static_cast<double>(spheres + points),
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void BM_TreeConforming(benchmark::State& state) {
  RunTree(state, Conforming(), 0.0);
}
void BM_TreeConformingLookAhead(benchmark::State& state) {
  RunTree(state, Conforming(), 0.002);
}
void BM_TreeLight(benchmark::State& state) {
  RunTree(state, Light(), 0.0);
}
void BM_TreeLightLookAhead(benchmark::State& state) {
  RunTree(state, Light(), 0.002);
}
BENCHMARK(BM_TreeConforming)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_TreeConformingLookAhead)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_TreeLight)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_TreeLightLookAhead)->Unit(benchmark::kMicrosecond);

void BM_FlatConforming(benchmark::State& state) {
  const Scene& scene = Conforming();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(QueryBruteForce(scene.points, scene.field, scene.poses[i++ % scene.poses.size()], 0.0));
  }
}
BENCHMARK(BM_FlatConforming)->Unit(benchmark::kMicrosecond);

void BM_BuildVoxmap32M(benchmark::State& state) {
  const TriangleMesh mesh = MakeBlockWithHole(0.3, 0.3, 0.1, 64);
  for (auto _ : state) benchmark::DoNotOptimize(BuildVoxmap(mesh, 0.001));
}
BENCHMARK(BM_BuildVoxmap32M)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
