#include "vps/mesh/trusted_normals.hpp"

#include <algorithm>
#include <cmath>

#include "vps/mesh/edge_table.hpp"
#include "vps/mesh/self_intersection.hpp"

namespace vps {
namespace {

constexpr double kStep = 1e-6;       // off the surface, of the box's diagonal; as kWeldRatio
constexpr double kTolerance = 0.25;  // of a winding number; five times the error of its dipoles, half way to 0.5

bool IsOnBorder(const TriangleMesh& mesh, const WindingNumber& winding, std::size_t triangle, double step_m) {
  const auto [a, b, c] = mesh.corners(triangle);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  if (!(glm::length(n) > 0.0)) return false;
  const glm::dvec3 off = step_m * glm::normalize(n);
  const glm::dvec3 middle = (a + b + c) / 3.0;
  return std::abs(winding.At(middle + off)) < kTolerance && std::abs(winding.At(middle - off) - 1.0) < kTolerance;
}

}  // namespace

std::vector<std::uint8_t> FindTrustedNormals(const TriangleMesh& mesh, const WindingNumber& winding,
                                             core::ParallelFor* workers) {
  const Box box = BoundingBox(mesh);
  const double step_m = kStep * glm::length(box.upper - box.lower);
  std::vector<std::uint8_t> is_good(mesh.triangles.size());
  core::ForEach(workers, is_good.size(),
                [&](std::size_t t) { is_good[t] = IsOnBorder(mesh, winding, t, step_m) ? 1 : 0; });
  const std::vector<std::uint8_t> is_intersecting = FindIntersectingTriangles(mesh, workers);
  for (std::size_t t = 0; t < is_good.size(); ++t) is_good[t] &= 1 - is_intersecting[t];
  const std::vector<EdgeUse> edges = SortedEdges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    const bool is_closed = end - i == 2 && edges[i].is_forward != edges[i + 1].is_forward;
    for (std::size_t j = i; j < end && !is_closed; ++j) is_good[edges[j].triangle] = 0;
    i = end;
  }
  std::vector<std::uint8_t> is_good_corner(mesh.vertices.size(), 1);
  for (std::size_t t = 0; t < is_good.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) is_good_corner[v] &= is_good[t];
  }
  std::vector<std::uint8_t> is_trusted(is_good.size());
  for (std::size_t t = 0; t < is_good.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    is_trusted[t] = is_good_corner[a] & is_good_corner[b] & is_good_corner[c];
  }
  return is_trusted;
}

}  // namespace vps
