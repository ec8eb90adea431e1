#include "vps/mesh/winding_number.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vps/mesh/ray_crossings.hpp"

namespace vps {
namespace {

// Distance over radius from which a group of triangles is approximated by a dipole. Not derived: keeps the error of the
// sum below 0.05 (test WindingNumber.IsOneInsideAndZeroOutside, 20 000 points).
constexpr double kFarRatio = 2.5;

}  // namespace

double WindingOfTriangle(const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& p) {
  const glm::dvec3 a = triangle[0] - p;
  const glm::dvec3 b = triangle[1] - p;
  const glm::dvec3 c = triangle[2] - p;
  const double la = glm::length(a);
  const double lb = glm::length(b);
  const double lc = glm::length(c);
  const double volume = glm::dot(a, glm::cross(b, c));
  const double denominator = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
  return std::atan2(volume, denominator) / (2.0 * std::numbers::pi);
}

WindingNumber::WindingNumber(const TriangleMesh& mesh)
    : is_closed_(CountOpenEdges(mesh) == 0), tree_(BuildBoxTree(mesh)), dipoles_(tree_.nodes.size()) {
  for (const std::uint32_t t : tree_.order) triangles_.push_back(mesh.corners(t));
  for (std::size_t n = 0; n < tree_.nodes.size(); ++n) {
    const BoxTree::Node& node = tree_.nodes[n];
    Dipole& dipole = dipoles_[n];
    double area = 0.0;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& [a, b, c] = triangles_[i];
      const glm::dvec3 area_normal = 0.5 * glm::cross(b - a, c - a);
      const double weight = glm::length(area_normal);
      area += weight;
      dipole.moment_m2 += area_normal;
      dipole.centre += weight * (a + b + c) / 3.0;
    }
    dipole.centre = area > 0.0 ? dipole.centre / area : 0.5 * (node.box.lower + node.box.upper);
    const glm::dvec3 farthest = glm::max(dipole.centre - node.box.lower, node.box.upper - dipole.centre);
    dipole.reach = kFarRatio * glm::length(farthest);
  }
}

double WindingNumber::At(const glm::dvec3& p) const {
  if (tree_.nodes.empty()) return 0.0;
  if (is_closed_) {
    if (const auto count = CountRayCrossings(tree_, triangles_, p)) return *count;
  }
  double sum = 0.0;
  std::array<std::uint32_t, 128> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const std::uint32_t n = stack[--size];
    const BoxTree::Node& node = tree_.nodes[n];
    const glm::dvec3 r = dipoles_[n].centre - p;
    const double distance = glm::length(r);
    if (distance > dipoles_[n].reach) {
      sum += glm::dot(r, dipoles_[n].moment_m2) / (4.0 * std::numbers::pi * distance * distance * distance);
    } else if (node.left == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) sum += WindingOfTriangle(triangles_[i], p);
    } else {
      stack[size++] = node.left;
      stack[size++] = node.left + 1;
    }
  }
  return sum;
}

}  // namespace vps
