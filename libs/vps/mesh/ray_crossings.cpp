#include "vps/mesh/ray_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vps {
namespace {

// About unit, and along no edge, plane or diagonal that a part's designer would choose. Else not derived.
constexpr std::array<glm::dvec3, 4> kDirections = {
    glm::dvec3{0.5127, 0.3394, 0.7886}, glm::dvec3{-0.6913, 0.6371, 0.3411}, glm::dvec3{0.2731, -0.8517, -0.4473},
    glm::dvec3{-0.4239, -0.2687, 0.8649}};

// Of the sizes that a product is made of: a smaller one has no sure sign. Five hundred times the rounding of a double.
constexpr double kSure = 1e-13;

enum class Passes { kBeside, kOutwards, kInwards, kDoubtful };

// On which sides of the edges the ray p + t d passes: the volumes d . (r_i x r_j), r from p to the corners, have one
// sign when it passes between them, and that sign is that of d . n, n the normal.
Passes PassesThrough(const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& p, const glm::dvec3& d) {
  const glm::dvec3 a = triangle[0] - p;
  const glm::dvec3 b = triangle[1] - p;
  const glm::dvec3 c = triangle[2] - p;
  const double sides[3] = {glm::dot(d, glm::cross(b, c)), glm::dot(d, glm::cross(c, a)), glm::dot(d, glm::cross(a, b))};
  const double margin = kSure * std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)});
  const double least = std::min({sides[0], sides[1], sides[2]});
  const double most = std::max({sides[0], sides[1], sides[2]});
  if (least < -margin && most > margin) return Passes::kBeside;
  const bool is_outwards = least > margin;
  if (!is_outwards && !(most < -margin)) return Passes::kDoubtful;
  // The line goes through the triangle; the ray does where the plane is before it: a . n and d . n have one sign.
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const double height = glm::dot(a, glm::cross(ab, ac));
  const double doubt = kSure * std::sqrt(glm::dot(a, a) * glm::dot(ab, ab) * glm::dot(ac, ac));
  if (!(std::abs(height) > doubt)) return Passes::kDoubtful;
  if ((height > 0.0) != is_outwards) return Passes::kBeside;
  return is_outwards ? Passes::kOutwards : Passes::kInwards;
}

// `pad`: above the rounding of the products here, so that no box is missed that holds a sure crossing.
bool Meets(const Box& box, const glm::dvec3& p, const glm::dvec3& inverse, double pad) {
  const glm::dvec3 to_lower = (box.lower - p) * inverse;
  const glm::dvec3 to_upper = (box.upper - p) * inverse;
  const glm::dvec3 first = glm::min(to_lower, to_upper);
  const glm::dvec3 last = glm::max(to_lower, to_upper);
  const double enters = std::max({first.x, first.y, first.z, 0.0});
  return enters <= std::min({last.x, last.y, last.z}) + pad;
}

std::optional<int> CountAlong(const BoxTree& tree, const std::vector<std::array<glm::dvec3, 3>>& triangles,
                              const glm::dvec3& p, const glm::dvec3& d) {
  const glm::dvec3 inverse = 1.0 / d;
  const Box& all = tree.nodes[0].box;
  const double pad = kSure * (glm::length(all.upper - all.lower) + glm::length(all.lower - p));
  int count = 0;
  std::array<std::uint32_t, 128> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const BoxTree::Node& node = tree.nodes[stack[--size]];
    if (!Meets(node.box, p, inverse, pad)) continue;
    if (node.left != 0) {
      stack[size++] = node.left;
      stack[size++] = node.left + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Passes passes = PassesThrough(triangles[i], p, d);
      if (passes == Passes::kDoubtful) return std::nullopt;
      if (passes != Passes::kBeside) count += passes == Passes::kOutwards ? 1 : -1;
    }
  }
  return count;
}

}  // namespace

std::optional<int> CountRayCrossings(const BoxTree& tree, const std::vector<std::array<glm::dvec3, 3>>& triangles,
                                     const glm::dvec3& p) {
  if (tree.nodes.empty()) return 0;
  for (const glm::dvec3& d : kDirections) {
    if (const auto count = CountAlong(tree, triangles, p, d)) return count;
  }
  return std::nullopt;
}

}  // namespace vps
