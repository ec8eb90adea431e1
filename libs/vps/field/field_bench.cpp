#include <benchmark/benchmark.h>

#include <random>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/voxmap/build_voxmap.hpp"

// Time to build the distance field, beside the layers of `paper` at the same voxel size.
namespace {

using namespace vps;

const TriangleMesh& Block() {
  static const TriangleMesh mesh = MakeBlockWithHole(0.05, 0.05, 0.01025, 128);
  return mesh;
}
const TriangleMesh& Torus() {
  static const TriangleMesh mesh = MakeTorus(0.1, 0.04, 256, 128);
  return mesh;
}

void BM_BuildField(benchmark::State& state, const TriangleMesh& mesh, double voxel_size_m) {
  std::size_t bytes = 0, creases = 0;
  for (auto _ : state) {
    const auto field = BuildField(mesh, voxel_size_m);
    bytes = field->num_bytes();
    creases = field->creases.size() / kPlanesPerCrease;
  }
  state.counters["MB"] = static_cast<double>(bytes) * 1e-6;
  state.counters["creases"] = static_cast<double>(creases);
}
void BM_BuildLayers(benchmark::State& state, const TriangleMesh& mesh, double voxel_size_m) {
  for (auto _ : state) benchmark::DoNotOptimize(BuildVoxmap(mesh, voxel_size_m));
}
BENCHMARK_CAPTURE(BM_BuildField, block_0_25mm, Block(), 0.00025)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(BM_BuildLayers, block_0_25mm, Block(), 0.00025)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(BM_BuildField, torus_1mm, Torus(), 0.001)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(BM_BuildLayers, torus_1mm, Torus(), 0.001)->Unit(benchmark::kMillisecond)->Iterations(1);

// One point after the other at random places: the scalar reference.
void BM_SampleField(benchmark::State& state) {
  static const DistanceField field = *BuildField(Block(), 0.00025);
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<float>(random() >> 40) * 0x1p-24f; };
  std::vector<glm::vec3> points;
  for (int i = 0; i < 4096; ++i) {
    points.emplace_back(uniform() * static_cast<float>(field.nx), uniform() * static_cast<float>(field.ny),
                        uniform() * static_cast<float>(field.nz));
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(SampleField(field, points[i++ % points.size()]));
}
BENCHMARK(BM_SampleField);

}  // namespace
