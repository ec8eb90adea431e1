#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/testing/many_objects.hpp"
#include "vps/testing/shapes.hpp"

// Whole cycles: poses set, Step, as haptic_node does it. Same objects, points, voxels and motion for both methods; the
// ratios are what counts. Run with --benchmark_enable_random_interleaving.
namespace {

using namespace vps;

constexpr std::uint32_t kPoints = 65536;

// Ten objects, 45 pairs: a peg of 20 mm is pressed to and fro in a hole of 20.1 mm (the heavy pair) and held by two
// jaws, six other parts pass by. Nothing is faster than 0.3 m/s.
class TenObjects {
 public:
  static constexpr int kPeriod = 4000;

  explicit TenObjects(Method method) {
    const std::filesystem::path parts = VR_OOS_SOURCE_DIR "/scenarios/module_replacement/meshes";
    const auto cook = [&](const TriangleMesh& mesh, double voxel_size_m = 0.001) {
      return std::make_shared<const CookedObject>(*Cook(mesh, {voxel_size_m, kPoints, method}));
    };
    const auto load = [&](const char* name) { return cook(*LoadMesh(parts / name)); };
    const auto jaw = cook(MakeBox({0.01, 0.02, 0.03}), 0.0005);
    WorldDescription description;
    description.method = method;
    description.objects = {{cook(MakeBlockWithHole(0.05, 0.05, 0.01005, 256), 0.00025), {}},
                           {cook(MakeCylinder(0.01, 0.1, 256), 0.0005), {}},
                           {jaw, {}},
                           {jaw, {}},
                           {load("module.obj"), {}},
                           {load("handle.obj"), {}},
                           {load("lever.obj"), {}},
                           {load("palm.obj"), {}},
                           {load("bracket.obj"), {}},
                           {cook(MakeTorus(0.05, 0.02, 256, 128)), {}}};
    for (std::uint16_t i = 0; i < 10; ++i) {
      description.objects[i].X_WO = PoseAt(i, 0);
      for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
    }
    world_ = *CollisionWorld::Create(description);
  }

  CollisionWorld& world() { return *world_; }
  void MoveTo(int step) {
    for (std::size_t i = 1; i < 10; ++i) world_->SetPose(i, PoseAt(i, step));
  }

 private:
  static core::Pose PoseAt(std::size_t i, int step) {
    const double t = 2.0 * M_PI * step / kPeriod;
    if (i == 0) return {};
    const core::Pose X_WPeg{
        core::QuaternionFromRotationVector({5e-4 * std::sin(5.0 * t), 5e-4 * std::cos(3.0 * t), 0.3 * std::sin(t)}),
        {8e-5 * std::cos(7.0 * t), 8e-5 * std::sin(7.0 * t), 0.02 + 0.01 * std::sin(2.0 * t)}};
    if (i == 1) return X_WPeg;
    if (i < 4) {  // 0.3 mm into the peg at its upper end, clear of the block
      const double side = i == 2 ? 1.0 : -1.0;
      return X_WPeg * core::Pose{{1, 0, 0, 0}, {side * (0.015 - 0.0003 - 1e-4 * std::sin(11.0 * t)), 0.0, 0.035}};
    }
    const double place = static_cast<double>(i - 4) * M_PI / 3.0;
    return {core::QuaternionFromRotationVector({std::sin(t + place), 0.5 * std::cos(t), 0.8 * std::sin(2.0 * t)}),
            {0.5 * std::cos(place) + 0.1 * std::cos(t), 0.5 * std::sin(place) + 0.1 * std::sin(t), 0.1 * std::sin(t)}};
  }
  std::unique_ptr<CollisionWorld> world_;
};

TenObjects& Ten(Method method) {
  static std::map<Method, std::unique_ptr<TenObjects>> scenes;
  std::unique_ptr<TenObjects>& scene = scenes[method];
  if (scene == nullptr) scene = std::make_unique<TenObjects>(method);
  return *scene;
}

bus::WorkerPool& Pool(unsigned num_workers) {
  static std::map<unsigned, std::unique_ptr<bus::WorkerPool>> pools;
  std::unique_ptr<bus::WorkerPool>& pool = pools[num_workers];
  if (pool == nullptr) pool = std::make_unique<bus::WorkerPool>(num_workers);
  return *pool;
}

// Every fifth pose of a motion; the counters are averages per cycle.
template <typename Scene>
void RunCycles(benchmark::State& state, Scene* scene, core::ParallelFor* workers) {
  int step = 0;
  double touching = 0.0;
  double tested = 0.0;
  double points = 0.0;
  for (auto _ : state) {
    scene->MoveTo(step);
    const StepReport& report = scene->world().Step(workers);
    step = (step + 5) % Scene::kPeriod;
    touching += report.pairs_in_contact;
    tested += report.pairs_tested;
    points += static_cast<double>(report.counters.points_tested);
  }
  const auto average = [](double sum) { return benchmark::Counter(sum, benchmark::Counter::kAvgIterations); };
  state.counters["touching"] = average(touching);
  state.counters["tested"] = average(tested);
  state.counters["points"] = average(points);
}

void BM_TenObjects(benchmark::State& state, Method method) {
  RunCycles(state, &Ten(method), &Pool(static_cast<unsigned>(state.range(0))));
}
BENCHMARK_CAPTURE(BM_TenObjects, paper, Method::kPaper)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("workers")
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_TenObjects, fast, Method::kFast)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("workers")
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

// 100 objects, 4950 pairs, ten touching, 65 536 points each. Five passes over the same poses; of each pose the best
// time counts, and of all poses the worst: worst_us. One iteration is five passes over 2000 poses.
void BM_HundredObjects(benchmark::State& state, Method method) {
  using test::ManyObjects;
  static std::map<Method, std::unique_ptr<ManyObjects>> scenes;
  std::unique_ptr<ManyObjects>& scene = scenes[method];
  if (scene == nullptr) {
    scene = std::make_unique<ManyObjects>(method, ManyObjects::CookParts(method, kPoints, 0.001), 100, 0);
  }
  core::SerialFor serial;
  std::vector<std::int64_t> best_ns(ManyObjects::kPeriod, 1'000'000'000);
  double touching = 0.0;
  double bounded = 0.0;
  double tested = 0.0;
  for (auto _ : state) {
    for (int pass = 0; pass < 5; ++pass) {
      for (int step = 0; step < ManyObjects::kPeriod; ++step) {
        const std::int64_t begin_ns = core::MonotonicNow_ns();
        scene->MoveTo(step);
        const StepReport& report = scene->world().Step(&serial);
        std::int64_t& best = best_ns[static_cast<std::size_t>(step)];
        best = std::min(best, core::MonotonicNow_ns() - begin_ns);
        touching += report.pairs_in_contact;
        bounded += report.pairs_bounded;
        tested += report.pairs_tested;
      }
    }
  }
  const double cycles = 5.0 * ManyObjects::kPeriod * static_cast<double>(state.iterations());
  std::sort(best_ns.begin(), best_ns.end());
  state.counters["median_us"] = 1e-3 * static_cast<double>(best_ns[best_ns.size() / 2]);
  state.counters["worst_us"] = 1e-3 * static_cast<double>(best_ns.back());
  state.counters["touching"] = touching / cycles;
  state.counters["bounded"] = bounded / cycles;
  state.counters["tested"] = tested / cycles;
}
BENCHMARK_CAPTURE(BM_HundredObjects, paper, Method::kPaper)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_HundredObjects, fast, Method::kFast)->Iterations(1)->Unit(benchmark::kMillisecond);

// 4950 pairs of 100 objects that all move far apart: the time of a pair is a cycle's by 4950.
void BM_IdlePairs(benchmark::State& state) {
  static const auto part =
      std::make_shared<const CookedObject>(*Cook(MakeTorus(0.05, 0.02, 48, 24), {0.001, 4096, Method::kFast}));
  WorldDescription description;
  description.method = Method::kFast;
  for (std::uint16_t i = 0; i < 100; ++i) {
    description.objects.push_back({part, {{1, 0, 0, 0}, {0.5 * (i % 10), 0.5 * (i / 10), 0}}});
    for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
  }
  const auto world = *CollisionWorld::Create(description);
  core::SerialFor serial;
  double phase = 0.0;
  for (auto _ : state) {
    phase += 0.002;
    for (std::uint16_t i = 0; i < 100; ++i) {
      world->SetPose(i, {{1, 0, 0, 0}, {0.5 * (i % 10) + 0.1 * std::sin(phase + i), 0.5 * (i / 10), 0}});
    }
    benchmark::DoNotOptimize(world->Step(&serial));
  }
  state.counters["time_per_pair"] =
      benchmark::Counter(4950.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_IdlePairs)->Unit(benchmark::kMicrosecond);

}  // namespace
