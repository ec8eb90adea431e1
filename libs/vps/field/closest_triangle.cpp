#include "vps/field/closest_triangle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vps {

TriangleField::TriangleField(const TriangleMesh& input, Signs signs, core::ParallelFor* workers) {
  TriangleMesh mesh = MergeDuplicateVertices(input);
  if (signs != Signs::kNormals) {
    winding_.emplace(mesh);
    signs_spread_ = signs == Signs::kWinding && CountOpenEdges(mesh) == 0;
    is_trusted_ = FindTrustedNormals(mesh, *winding_, workers);
  }
  vertex_normals_.assign(mesh.vertices.size(), glm::dvec3(0.0));
  normals_.reserve(mesh.triangles.size());
  const auto key = [](std::uint32_t a, std::uint32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto corners = mesh.corners(i);
    glm::dvec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(n);
    n = length > 0.0 ? n / length : glm::dvec3(0.0);
    normals_.push_back(n);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 u = corners[(k + 1) % 3] - corners[k];
      const glm::dvec3 v = corners[(k + 2) % 3] - corners[k];
      const double angle = std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
      vertex_normals_[mesh.triangles[i][k]] += angle * n;
    }
  }
  vertices_ = std::move(mesh.vertices);
  indices_ = std::move(mesh.triangles);
  // Sides of triangles that share an edge stand next to each other once sorted.
  struct Side {
    std::uint64_t edge;
    std::uint32_t triangle, k;
  };
  std::vector<Side> sides;
  sides.reserve(3 * indices_.size());
  for (std::uint32_t i = 0; i < indices_.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) sides.push_back({key(indices_[i][k], indices_[i][(k + 1) % 3]), i, k});
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle; });
  edge_normals_.resize(indices_.size());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    glm::dvec3 sum(0.0);
    for (; end < sides.size() && sides[end].edge == sides[begin].edge; ++end) sum += normals_[sides[end].triangle];
    for (std::size_t i = begin; i < end; ++i) edge_normals_[sides[i].triangle][sides[i].k] = glm::vec3(sum);
  }
  sides = {};
  std::vector<FloatBox> boxes;
  boxes.reserve(indices_.size());
  for (std::uint32_t i = 0; i < indices_.size(); ++i) {
    const auto [a, b, c] = corners(i);
    boxes.push_back(RoundedOutwards(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))));
  }
  tree_ = WideBoxTree(boxes);
}

// Voronoi regions of the triangle's corners, edges and face (Ericson 2005, section 5.1.5).
ClosestFeature TriangleField::Closest(std::uint32_t triangle, const glm::dvec3& p) const {
  const auto [a, b, c] = corners(triangle);
  const auto made = [&](const glm::dvec3& q, std::uint8_t feature) {
    const glm::dvec3 r = p - q;
    return ClosestFeature{q, glm::dot(r, r), feature};
  };
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 ap = p - a;
  const double d1 = glm::dot(ab, ap);
  const double d2 = glm::dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return made(a, 0);
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp);
  const double d4 = glm::dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return made(b, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return made(a + (d1 / (d1 - d3)) * ab, 3);
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp);
  const double d6 = glm::dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return made(c, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return made(a + (d2 / (d2 - d6)) * ac, 5);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return made(b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 4);
  const double denominator = 1.0 / (va + vb + vc);
  return made(a + (vb * denominator) * ab + (vc * denominator) * ac, 6);
}

ClosestFeature TriangleField::ClosestOfAll(const glm::dvec3& p, std::uint32_t* triangle) const {
  ClosestFeature best = Closest(*triangle, p);
  tree_.ForNearer(p, &best.squared_distance, [&](std::uint32_t candidate) {
    const ClosestFeature here = Closest(candidate, p);
    if (here.squared_distance >= best.squared_distance) return;
    best = here;
    *triangle = candidate;
  });
  return best;
}

std::optional<ClosestFeature> TriangleField::ClosestWithin(const glm::dvec3& p, double limit_m,
                                                           std::size_t* num_tests) const {
  std::optional<ClosestFeature> best;
  double limit = limit_m * limit_m;
  tree_.ForNearer(p, &limit, [&](std::uint32_t candidate) {
    ++*num_tests;
    // No triangle is nearer than its plane; the margin is more than rounding.
    const double height = glm::dot(normals_[candidate], p - vertices_[indices_[candidate][0]]);
    if (height * height >= limit * (1.0 + 1e-12)) return;
    const ClosestFeature here = Closest(candidate, p);
    if (here.squared_distance >= limit) return;
    best = here;
    limit = here.squared_distance;
  });
  return best;
}

glm::dvec3 TriangleField::PseudoNormal(std::uint32_t triangle, std::uint8_t feature) const {
  if (feature < 3) return vertex_normals_[indices_[triangle][feature]];
  if (feature < 6) return glm::dvec3(edge_normals_[triangle][feature - 3]);
  return normals_[triangle];
}

double TriangleField::SignOfSide(std::uint32_t triangle, const ClosestFeature& closest, const glm::dvec3& p) const {
  return glm::dot(p - closest.point, PseudoNormal(triangle, closest.feature)) >= 0.0 ? 1.0 : -1.0;
}

TriangleField::Value TriangleField::SignedValue(std::uint32_t triangle, const ClosestFeature& closest,
                                                const glm::dvec3& p) const {
  const double sign = side_is_sign(triangle) ? SignOfSide(triangle, closest, p) : SignOfWinding(p);
  return ValueWithSign(triangle, closest, p, sign);
}

TriangleField::Value TriangleField::SignedValue(std::uint32_t triangle, const ClosestFeature& closest,
                                                const glm::dvec3& p, SettledSigns* around) const {
  if (side_is_sign(triangle)) return ValueWithSign(triangle, closest, p, SignOfSide(triangle, closest, p));
  const double sign = around->SignAt(p, std::sqrt(closest.squared_distance), [&] { return SignOfWinding(p); });
  return ValueWithSign(triangle, closest, p, sign);
}

TriangleField::Value TriangleField::ValueWithSign(std::uint32_t triangle, const ClosestFeature& closest,
                                                  const glm::dvec3& p, double sign) const {
  const glm::dvec3 pseudo = PseudoNormal(triangle, closest.feature);
  const glm::dvec3 r = p - closest.point;
  const double distance = std::sqrt(closest.squared_distance);
  const double side = SignOfSide(triangle, closest, p);
  Value value;
  value.distance = sign * distance;
  // Over a face the direction is the face's normal; on an edge or a corner itself it is the pseudonormal's.
  const double length = glm::length(pseudo);
  if ((closest.feature == 6 || distance < 1e-9) && length > 0.0) {
    value.gradient = pseudo / (side == sign ? length : -length);
  } else if (distance > 0.0) {
    value.gradient = r * (sign / distance);
  }
  return value;
}

}  // namespace vps
