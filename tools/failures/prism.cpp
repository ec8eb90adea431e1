#include "tools/failures/prism.hpp"

#include <cmath>
#include <numbers>

namespace failures {

vps::TriangleMesh MakePrism(const std::vector<glm::dvec2>& outline, double length_m) {
  vps::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double y : {-0.5 * length_m, 0.5 * length_m}) {
    for (const glm::dvec2& p : outline) mesh.vertices.emplace_back(p.x, y, p.y);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
    if (i == 0 || j == 0) continue;
    mesh.triangles.push_back({0, j, i});
    mesh.triangles.push_back({n, n + i, n + j});
  }
  // Seen from -y, x points right and z up: a counter-clockwise outline has its front face towards -y.
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

vps::TriangleMesh MakeRoundedBox(const glm::dvec3& size_m, double radius_m) {
  constexpr int kSteps = 8;
  std::vector<glm::dvec2> outline;
  const glm::dvec2 half(0.5 * size_m.x - radius_m, 0.5 * size_m.z - radius_m);
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec2 middle(corner == 0 || corner == 3 ? half.x : -half.x, corner < 2 ? half.y : -half.y);
    for (int i = 0; i <= (radius_m > 0.0 ? kSteps : 0); ++i) {
      const double angle = 0.5 * std::numbers::pi * (corner + static_cast<double>(i) / kSteps);
      outline.push_back(middle + radius_m * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
  }
  return MakePrism(outline, size_m.y);
}

}  // namespace failures
