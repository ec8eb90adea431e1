#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <vector>

#include "vps/field/build_field.hpp"
#include "vps/query/tree_query.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"
#include "vps/walk/field_walk.hpp"

// The same meshes, number of points, voxel size and poses for `paper` and `fast`: the ratios are what counts.
namespace {

using namespace vps;

struct Contact {
  Voxmap layers;
  PointTree point_tree;
  DistanceField field;
  SampleTree samples;
  std::vector<core::Pose> poses;

  Contact(const TriangleMesh& field_mesh, double voxel_size_m, const TriangleMesh& sampled_mesh, std::uint32_t count)
      : layers(*BuildVoxmap(field_mesh, voxel_size_m)),
        point_tree(BuildTree(*BuildPointshell(sampled_mesh, count))),
        field(*BuildField(field_mesh, voxel_size_m)),
        samples(BuildSampleTree(*SampleSurface(sampled_mesh, count))) {}
};

class Random {
 public:
  double Signed() { return static_cast<double>(engine_() >> 11) * 0x1p-52 - 1.0; }

 private:
  std::mt19937_64 engine_{1};
};

// A 20 mm peg pressed in a hole of 20.1 mm.
const Contact& Peg() {
  static const std::unique_ptr<Contact> contact = [] {
    auto c = std::make_unique<Contact>(MakeBlockWithHole(0.05, 0.05, 0.01005, 256), 0.00025,
                                       MakeCylinder(0.01, 0.06, 256), 65536);
    Random random;
    for (int i = 0; i < 64; ++i) {
      core::Pose X;
      X.translation = {1.2e-4 * random.Signed(), 1.2e-4 * random.Signed(), 5e-3 * random.Signed()};
      X.rotation =
          core::QuaternionFromRotationVector({2e-3 * random.Signed(), 2e-3 * random.Signed(), 3.0 * random.Signed()});
      c->poses.push_back(X);
    }
    return c;
  }();
  return *contact;
}

// Two tori that touch at about one place: 0.5 mm deep, or 0.5 mm apart.
const Contact& Tori(double depth_m) {
  const auto make = [](double depth) {
    auto c = std::make_unique<Contact>(MakeTorus(0.1, 0.04, 256, 128), 0.001, MakeTorus(0.05, 0.02, 256, 128), 65536);
    Random random;
    for (int i = 0; i < 64; ++i) {
      core::Pose X;
      const double angle = 3.1 * random.Signed();
      X.translation = (0.21 - depth) * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
      X.rotation = core::QuaternionFromRotationVector({0.0, 0.0, 3.0 * random.Signed()});
      c->poses.push_back(X);
    }
    return c;
  };
  static const std::unique_ptr<Contact> light = make(0.0005);
  static const std::unique_ptr<Contact> near = make(-0.0005);
  return depth_m > 0.0 ? *light : *near;
}
const Contact& Light() {
  return Tori(1.0);
}
const Contact& Near() {
  return Tori(-1.0);
}
const Contact& Idle() {
  static const std::unique_ptr<Contact> contact = [] {
    auto c = std::make_unique<Contact>(Near());
    c->poses.assign(1, {});
    c->poses[0].translation.x = 0.5;
    return c;
  }();
  return *contact;
}

void BM_Paper(benchmark::State& state, const Contact& (*contact)()) {
  const Contact& c = contact();
  QueryScratch scratch(c.point_tree);
  std::uint64_t points = 0;
  std::uint64_t colliding = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const QueryResult r = QueryTree(c.point_tree, c.layers, c.poses[i++ % c.poses.size()], 0.0, &scratch);
    points += r.points_tested;
    colliding += r.num_colliding;
    // Eq. 1: the sum is part of the query here as it is in the walk.
    glm::dvec3 sum(0.0);
    for (std::uint32_t k = 0; k < r.num_hits; ++k) {
      const std::uint32_t p = scratch.hits[k].point;
      sum += static_cast<double>(scratch.hits[k].penetration_m) *
             glm::dvec3(c.point_tree.nx[p], c.point_tree.ny[p], c.point_tree.nz[p]);
    }
    benchmark::DoNotOptimize(sum);
  }
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(state.iterations());
  state.counters["colliding"] = static_cast<double>(colliding) / static_cast<double>(state.iterations());
}

void BM_Fast(benchmark::State& state, const Contact& (*contact)(), InstructionSet set) {
  if (!IsAvailable(set)) {
    state.SkipWithError("this processor has not got it");
    return;
  }
  const Contact& c = contact();
  FieldWalkScratch scratch(c.samples);
  std::uint64_t points = 0;
  std::uint64_t spheres = 0;
  std::uint64_t colliding = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const FieldWalkResult r = WalkField(c.samples, c.field, c.poses[i++ % c.poses.size()], 0.0, set, &scratch);
    points += r.points_tested;
    spheres += r.spheres_tested;
    colliding += r.num_colliding;
    benchmark::DoNotOptimize(r);
  }
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(state.iterations());
  state.counters["spheres"] = static_cast<double>(spheres) / static_cast<double>(state.iterations());
  state.counters["colliding"] = static_cast<double>(colliding) / static_cast<double>(state.iterations());
}

#define VPS_BENCH_PAIR(name)                                                                                   \
  BENCHMARK_CAPTURE(BM_Paper, name, name)->Unit(benchmark::kMicrosecond);                                      \
  BENCHMARK_CAPTURE(BM_Fast, name##_portable, name, InstructionSet::kPortable)->Unit(benchmark::kMicrosecond); \
  BENCHMARK_CAPTURE(BM_Fast, name##_avx2, name, InstructionSet::kAvx2)->Unit(benchmark::kMicrosecond);         \
  BENCHMARK_CAPTURE(BM_Fast, name##_avx512, name, InstructionSet::kAvx512)->Unit(benchmark::kMicrosecond)
VPS_BENCH_PAIR(Peg);
VPS_BENCH_PAIR(Light);
VPS_BENCH_PAIR(Near);
VPS_BENCH_PAIR(Idle);

// Lower bound of a walk's time: reading the words of the points that it tests, their indices known.
void BM_Gather(benchmark::State& state, const Contact& (*contact)()) {
  const Contact& c = contact();
  FieldWalkScratch scratch(c.samples);
  std::vector<std::vector<std::uint32_t>> indices;
  std::size_t points = 0;
  for (const core::Pose& X : c.poses) {
    const FieldTransform T(X, c.field);
    std::vector<std::uint32_t>& of_pose = indices.emplace_back();
    WalkField(c.samples, c.field, X, 0.0, &scratch);
    for (const std::uint32_t block : scratch.tested_blocks()) {
      const PointBlock& b = c.samples.points[block];
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        const glm::vec3 p = glm::clamp(T.ToVoxels({b.x[k], b.y[k], b.z[k]}), glm::vec3(0.0f),
                                       glm::vec3(c.field.nx - 1, c.field.ny - 1, c.field.nz - 1));
        const glm::ivec3 v(p);
        of_pose.push_back(c.field.bricks[static_cast<std::size_t>(
                              ((v.z >> 3) * (c.field.ny >> 3) + (v.y >> 3)) * (c.field.nx >> 3) + (v.x >> 3))] +
                          WordInBrick(v.x, v.y, v.z));
      }
    }
    points += of_pose.size();
  }
  std::size_t i = 0;
  for (auto _ : state) {
    std::uint32_t sums[4] = {};
    const std::vector<std::uint32_t>& of_pose = indices[i++ % indices.size()];
    for (std::size_t k = 0; k + 4 <= of_pose.size(); k += 4) {
      for (std::size_t j = 0; j < 4; ++j) sums[j] += c.field.words[of_pose[k + j]];
    }
    benchmark::DoNotOptimize(sums);
  }
  state.counters["points"] = static_cast<double>(points) / static_cast<double>(c.poses.size());
}
BENCHMARK_CAPTURE(BM_Gather, Peg, Peg)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_Gather, Light, Light)->Unit(benchmark::kMicrosecond);

const Contact& OnePeg() {
  static const std::unique_ptr<Contact> contact = [] {
    auto c = std::make_unique<Contact>(Peg());
    c->poses.resize(1);
    return c;
  }();
  return *contact;
}
VPS_BENCH_PAIR(OnePeg);
BENCHMARK_CAPTURE(BM_Gather, OnePeg, OnePeg)->Unit(benchmark::kMicrosecond);

void BM_FastFlat(benchmark::State& state) {
  const Contact& c = Peg();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(WalkFieldFlat(c.samples, c.field, c.poses[i++ % c.poses.size()], 0.0));
  }
}
BENCHMARK(BM_FastFlat)->Unit(benchmark::kMicrosecond);

}  // namespace
