#include "vps/mesh/self_intersection.hpp"

#include <algorithm>
#include <optional>

#include "vps/mesh/box_tree.hpp"

namespace vps {
namespace {

// Relative to the triangles' own size: what is nearer than this only touches.
constexpr double kTouch = 1e-7;

// Where the open segment p q pierces the inside of the triangle.
std::optional<glm::dvec3> Pierce(const glm::dvec3& p, const glm::dvec3& q, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double area2 = glm::length(n);
  if (!(area2 > 0.0)) return std::nullopt;
  const double longest = std::max({glm::length(t[1] - t[0]), glm::length(t[2] - t[1]), glm::length(t[0] - t[2])});
  const double hp = glm::dot(n, p - t[0]) / area2;
  const double hq = glm::dot(n, q - t[0]) / area2;
  const double margin = kTouch * std::max(longest, glm::length(q - p));
  if (!((hp > margin && hq < -margin) || (hp < -margin && hq > margin))) return std::nullopt;
  const glm::dvec3 x = p + (hp / (hp - hq)) * (q - p);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 e = t[(k + 1) % 3] - t[k];
    const double inside = glm::dot(glm::cross(n, e), x - t[k]) / (area2 * glm::length(e));  // height over the edge
    if (!(inside > margin)) return std::nullopt;
  }
  return x;
}

std::optional<glm::dvec3> Cross(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const auto corners_a = mesh.corners(a);
  const auto corners_b = mesh.corners(b);
  for (int k = 0; k < 3; ++k) {
    if (const auto x = Pierce(corners_a[k], corners_a[(k + 1) % 3], corners_b)) return x;
    if (const auto x = Pierce(corners_b[k], corners_b[(k + 1) % 3], corners_a)) return x;
  }
  return std::nullopt;
}

int SharedVertices(const std::array<std::uint32_t, 3>& a, const std::array<std::uint32_t, 3>& b) {
  int shared = 0;
  for (const std::uint32_t v : a) shared += v == b[0] || v == b[1] || v == b[2] ? 1 : 0;
  return shared;
}

Box BoxOf(const TriangleMesh& mesh, std::uint32_t t) {
  const auto [a, b, c] = mesh.corners(t);
  return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
}

}  // namespace

std::vector<Crossing> FindCrossings(const TriangleMesh& mesh, std::size_t max_crossings) {
  std::vector<Crossing> crossings;
  const BoxTree tree = BuildBoxTree(mesh);
  std::vector<std::uint32_t> near;
  for (std::uint32_t a = 0; a < mesh.triangles.size() && crossings.size() < max_crossings; ++a) {
    const Box box = BoxOf(mesh, a);
    near.clear();
    ForOverlapping(tree, box, [&](std::uint32_t b) {
      if (b > a && SharedVertices(mesh.triangles[a], mesh.triangles[b]) < 2 && Overlap(box, BoxOf(mesh, b))) {
        near.push_back(b);
      }
    });
    std::sort(near.begin(), near.end());
    for (const std::uint32_t b : near) {
      if (const auto x = Cross(mesh, a, b); x && crossings.size() < max_crossings) crossings.push_back({a, b, *x});
    }
  }
  return crossings;
}

}  // namespace vps
