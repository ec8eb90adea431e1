#include "tools/contact/structures.hpp"

#include <algorithm>
#include <cmath>

#include "bus/rt/worker_pool.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/tree/build_tree.hpp"

namespace contact {
namespace {

Structures::Cooked Build(const Parts& parts, const Structures::Key& key) {
  const vps::TriangleMesh& mesh = key.is_B ? parts.B : parts.A;
  core::Result<vps::CookedObject> cooked = vps::CookedObject{};
  if (key.is_even) {
    const vps::SurfaceSamples samples = EvenSamples(mesh, key.num_points);
    if (key.method == vps::Method::kFast) {
      cooked->samples = vps::BuildSampleTree(samples);
      for (std::uint32_t n = key.num_points / 4; n >= 256; n /= 4) {
        cooked->coarser.push_back(vps::BuildSampleTree(EvenSamples(mesh, n)));
      }
      cooked->surface = vps::BuildSurfaceTree(mesh, 4.0 * std::sqrt(vps::SurfaceArea_m2(mesh) / key.num_points));
    } else {
      vps::Pointshell shell;
      shell.points_m = samples.points_m;
      shell.inward_normals = samples.inward_normals;
      cooked->points = vps::BuildTree(shell);
    }
  } else {
    cooked = vps::Cook(mesh, {key.voxel_size_m, key.num_points, key.method});
  }
  if (!cooked) return core::Fail(cooked.error().code, (key.is_B ? "B: " : "A: ") + cooked.error().detail);
  return std::make_shared<const vps::CookedObject>(std::move(*cooked));
}

}  // namespace

Structures::Cooked Structures::Get(const Key& key) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = built_.find(key); found != built_.end()) return found->second;
  }
  Cooked cooked = Build(parts_, key);
  const std::lock_guard lock(mutex_);
  return built_.emplace(key, std::move(cooked)).first->second;
}

void Structures::Prepare(const std::vector<Key>& keys) {
  struct Job {
    Structures* structures;
    std::vector<Key> keys;
  } job{this, keys};
  std::sort(job.keys.begin(), job.keys.end());
  job.keys.erase(std::unique(job.keys.begin(), job.keys.end()), job.keys.end());
  bus::WorkerPool workers(2, "build");
  workers.Run(
      job.keys.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        (void)todo.structures->Get(todo.keys[i]);
      },
      &job);
}

vps::SurfaceSamples EvenSamples(const vps::TriangleMesh& mesh, std::uint32_t num_points) {
  double area = 0.0;
  std::vector<double> until(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    until[i] = area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  vps::SurfaceSamples samples;
  samples.areas_m2.assign(num_points, area / num_points);
  std::size_t triangle = 0;
  for (std::uint32_t k = 0; k < num_points; ++k) {
    while (triangle + 1 < until.size() && until[triangle] < (k + 0.5) * area / num_points) ++triangle;
    const auto [a, b, c] = mesh.corners(triangle);
    // Roberts' R2 sequence: frac(1/2 + k / g), frac(1/2 + k / g^2), with g^3 = g + 1; folded from the square to the
    // triangle.
    double u = std::fmod(0.5 + k * 0.7548776662466927, 1.0);
    double v = std::fmod(0.5 + k * 0.5698402909980532, 1.0);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    samples.points_m.push_back(a + u * (b - a) + v * (c - a));
    samples.inward_normals.push_back(-glm::normalize(glm::cross(b - a, c - a)));
  }
  return samples;
}

}  // namespace contact
