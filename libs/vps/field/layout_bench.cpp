#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/shapes.hpp"

// Two layouts of the same distances, one point after the other: the field's 32-bit planes with creases, and 16-bit
// distances at the voxels' centres, interpolated trilinearly, in bricks of 9^3 so that one brick answers a point.
namespace {

using namespace vps;

struct Trilinear {
  static constexpr int kSide = 9;
  static constexpr float kSteps = 4096.0f;  // per voxel
  std::vector<std::uint32_t> bricks;        // first value, x fastest; 0: none
  std::vector<std::int16_t> values;
  int bx = 0, by = 0;

  Trilinear(const DistanceField& field, const oracle::MeshDistance& exact) : bricks(field.bricks.size(), 0) {
    bx = field.nx >> 3;
    by = field.ny >> 3;
    values.resize(1);
    for (std::size_t slot = 0; slot < bricks.size(); ++slot) {
      if (field.bricks[slot] == 0) continue;
      bricks[slot] = static_cast<std::uint32_t>(values.size());
      const auto b = static_cast<int>(slot);
      const glm::dvec3 corner = 8.0 * glm::dvec3(b % bx, b / bx % by, b / bx / by);
      for (int i = 0; i < kSide * kSide * kSide; ++i) {
        const glm::dvec3 p = corner + glm::dvec3(i % kSide, i / kSide % kSide, i / kSide / kSide) + 0.5;
        const double d = exact.SignedDistance(field.origin_m + field.voxel_size_m * p) / field.voxel_size_m;
        values.push_back(static_cast<std::int16_t>(std::lround(std::clamp(d, -7.9, 7.9) * double{kSteps})));
      }
    }
  }

  [[nodiscard]] FieldSample Sample(const glm::vec3& p) const {
    const glm::vec3 q = p - 0.5f;
    const glm::ivec3 c(q);
    const glm::vec3 f = q - glm::vec3(c);
    const std::uint32_t brick = bricks[static_cast<std::size_t>(((c.z >> 3) * by + (c.y >> 3)) * bx + (c.x >> 3))];
    const std::int16_t* v = &values[brick + static_cast<std::uint32_t>(((c.z & 7) * 9 + (c.y & 7)) * 9 + (c.x & 7))];
    float corner[8];
    for (int k = 0; k < 8; ++k) corner[k] = static_cast<float>(v[(k & 1) + (k >> 1 & 1) * 9 + (k >> 2) * 81]);
    const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
    float x[4], dx[4];
    for (int k = 0; k < 4; ++k) {
      x[k] = mix(corner[2 * k], corner[2 * k + 1], f.x);
      dx[k] = corner[2 * k + 1] - corner[2 * k];
    }
    const float y0 = mix(x[0], x[1], f.y);
    const float y1 = mix(x[2], x[3], f.y);
    FieldSample sample;
    sample.distance = mix(y0, y1, f.z) / kSteps;
    sample.gradient = glm::vec3(mix(mix(dx[0], dx[1], f.y), mix(dx[2], dx[3], f.y), f.z),
                                mix(x[1] - x[0], x[3] - x[2], f.z), y1 - y0) /
                      kSteps;
    return sample;
  }
  [[nodiscard]] std::size_t num_bytes() const { return 2 * values.size() + 4 * bricks.size(); }
};

struct Scene {
  Scene(const TriangleMesh& mesh, double voxel_size_m)
      : exact(mesh), field(*BuildField(mesh, voxel_size_m)), trilinear(field, exact) {
    std::mt19937_64 random(7);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    while (points.size() < 20000) {
      const auto corners = mesh.corners(static_cast<std::size_t>(unit() * static_cast<double>(mesh.triangles.size())));
      double u = unit();
      double v = unit();
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      const glm::dvec3 offset = 2.0 * glm::dvec3(unit(), unit(), unit()) - 1.0;
      const glm::dvec3 p =
          corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]) + 1.5 * voxel_size_m * offset;
      const double d = exact.SignedDistance(p) / voxel_size_m;
      if (std::abs(d) > 1.5) continue;
      points.emplace_back((p - field.origin_m) / voxel_size_m);
      distances.push_back(d);
    }
  }
  oracle::MeshDistance exact;
  DistanceField field;
  Trilinear trilinear;
  std::vector<glm::vec3> points;
  std::vector<double> distances;
};

const Scene& Block() {
  static const Scene scene(MakeBlockWithHole(0.03, 0.02, 0.01005, 128), 0.0005);
  return scene;
}
const Scene& Torus() {
  static const Scene scene(MakeTorus(0.03, 0.01, 64, 32), 0.0005);
  return scene;
}

template <class SamplePoint>
void Run(benchmark::State& state, const Scene& scene, std::size_t num_bytes, SamplePoint&& sample) {
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(sample(scene.points[i]));
    i = i + 1 < scene.points.size() ? i + 1 : 0;
  }
  std::vector<double> errors;
  double mean = 0.0;
  for (std::size_t k = 0; k < scene.points.size(); ++k) {
    errors.push_back(std::abs(double{sample(scene.points[k]).distance} - scene.distances[k]));
    mean += errors.back() / static_cast<double>(scene.points.size());
  }
  std::sort(errors.begin(), errors.end());
  state.counters["mean"] = mean;
  state.counters["p95"] = errors[errors.size() * 95 / 100];
  state.counters["max"] = errors.back();
  state.counters["MB"] = static_cast<double>(num_bytes) * 1e-6;
}

void BM_LayoutPlanes(benchmark::State& state, const Scene& (*scene)()) {
  const Scene& s = scene();
  Run(state, s, s.field.num_bytes(), [&](const glm::vec3& p) { return SampleField(s.field, p); });
}
void BM_LayoutTrilinear(benchmark::State& state, const Scene& (*scene)()) {
  const Scene& s = scene();
  Run(state, s, s.trilinear.num_bytes(), [&](const glm::vec3& p) { return s.trilinear.Sample(p); });
}
BENCHMARK_CAPTURE(BM_LayoutPlanes, block, Block);
BENCHMARK_CAPTURE(BM_LayoutTrilinear, block, Block);
BENCHMARK_CAPTURE(BM_LayoutPlanes, torus, Torus);
BENCHMARK_CAPTURE(BM_LayoutTrilinear, torus, Torus);

}  // namespace
