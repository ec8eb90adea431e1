#include <algorithm>

#include "scene/load_scenario.hpp"
#include "tools/contact/methods/method.hpp"

namespace contact {

double SurfaceArea(const vps::TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

Resolution ResolveResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const Resolution& resolution) {
  Resolution resolved = resolution;
  const vps::Box box = vps::BoundingBox(A);
  const glm::dvec3 size = box.upper - box.lower;
  if (resolution.accuracy_m > 0.0) resolved.voxel_size_m = scene::kVoxelsPerAccuracy * resolution.accuracy_m;
  if (resolved.voxel_size_m <= 0.0) resolved.voxel_size_m = std::max({size.x, size.y, size.z}) / 256.0;
  if (resolved.num_points == 0) {
    const double wanted = SurfaceArea(B) / (resolved.voxel_size_m * resolved.voxel_size_m);
    resolved.num_points = static_cast<std::uint32_t>(std::clamp(wanted, 1e3, resolution.accuracy_m > 0.0 ? 1e6 : 1e5));
  }
  return resolved;
}

}  // namespace contact
