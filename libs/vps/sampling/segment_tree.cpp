#include "vps/sampling/segment_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vps {
namespace {

// Free: answers do not depend on it. Of 8 to 1000, 64 to 128 took the least time on a gear of 20,000 triangles.
constexpr std::size_t kMostListed = 64;
// Free likewise: after a list was too long, the next one is tried with a reach shorter by this factor.
constexpr double kShorter = 0.5;

// The boxes of triangles without area are those of their edges and corners.
BoxTree TreeOf(const std::vector<std::array<glm::dvec3, 2>>& segments) {
  TriangleMesh mesh;
  for (const auto& [a, b] : segments) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(a);
    mesh.vertices.push_back(b);
    mesh.triangles.push_back({first, first + 1, first + 1});
  }
  return BuildBoxTree(mesh);
}

std::vector<FloatBox> BoxesOf(const std::vector<std::array<glm::dvec3, 2>>& segments) {
  std::vector<FloatBox> boxes;
  boxes.reserve(segments.size());
  for (const auto& [a, b] : segments) boxes.push_back(RoundedOutwards(glm::min(a, b), glm::max(a, b)));
  return boxes;
}

}  // namespace

inline double SegmentTree::SquaredDistance(std::uint32_t item, const glm::dvec3& p) const {
  const auto& [a, b] = segments_[item];
  const glm::dvec3 along = b - a;
  const double squared_m2 = glm::dot(along, along);
  const double t = squared_m2 > 0.0 ? std::clamp(glm::dot(p - a, along) / squared_m2, 0.0, 1.0) : 0.0;
  const glm::dvec3 r = p - (a + t * along);
  return glm::dot(r, r);
}

SegmentTree::SegmentTree(std::vector<std::array<glm::dvec3, 2>> segments)
    : segments_(std::move(segments)),
      tree_(TreeOf(segments_)),
      nearest_(BoxesOf(segments_)),
      leaf_of_(segments_.size()) {
  for (std::uint32_t n = 0; n < tree_.nodes.size(); ++n) {
    const BoxTree::Node& node = tree_.nodes[n];
    if (node.left != 0) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) leaf_of_[tree_.order[i]] = n;
  }
}

SegmentTree::Nearby SegmentTree::Around(const Box& box) const {
  Nearby nearby;
  nearby.box = box;
  nearby.is_listed = ListOverlapping(box, &nearby.items);
  return nearby;
}

// False: too many.
bool SegmentTree::ListOverlapping(const Box& box, std::vector<std::uint32_t>* items) const {
  if (tree_.nodes.empty()) return true;
  std::array<std::uint32_t, 128> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const BoxTree::Node& node = tree_.nodes[stack[--size]];
    if (!Overlap(node.box, box)) continue;
    if (node.left != 0) {
      stack[size++] = node.left;
      stack[size++] = node.left + 1;
      continue;
    }
    items->insert(items->end(), tree_.order.begin() + node.first, tree_.order.begin() + node.first + node.count);
    if (items->size() <= kMostListed) continue;
    items->clear();
    return false;
  }
  return true;
}

SegmentTree::Nearby SegmentTree::Narrow(const Nearby& nearby, const glm::dvec3& centre, double reach_m) const {
  Nearby narrow;
  narrow.outer = &nearby;
  narrow.box = nearby.box;
  narrow.centre = centre;
  narrow.reach_m = reach_m;
  narrow.is_listed = true;
  const double squared_m2 = reach_m * reach_m;
  if (nearby.is_listed) {
    for (const std::uint32_t i : nearby.items) {
      if (SquaredDistance(i, centre) < squared_m2) narrow.items.push_back(i);
    }
    return narrow;
  }
  narrow.listless_m = nearby.listless_m;
  narrow.is_listed = false;
  if (reach_m > kShorter * nearby.listless_m) return narrow;
  double limit_m2 = squared_m2;
  nearest_.ForNearer(centre, &limit_m2, [&](std::uint32_t i) {
    if (!(SquaredDistance(i, centre) < squared_m2) || !Contains(nearby, i)) return;
    narrow.items.push_back(i);
    if (narrow.items.size() > kMostListed) limit_m2 = 0.0;  // nothing is nearer: ends the search
  });
  narrow.is_listed = narrow.items.size() <= kMostListed;
  if (!narrow.is_listed) {
    narrow.items.clear();
    narrow.listless_m = reach_m;
  }
  return narrow;
}

double SegmentTree::Distance_m(const glm::dvec3& p, const Nearby& nearby, double lossless_m, double far_m) const {
  if (nearby.is_listed) {
    double squared_m2 = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : nearby.items) squared_m2 = std::min(squared_m2, SquaredDistance(i, p));
    return std::sqrt(squared_m2);
  }
  const double any_m = SearchTree_m(p, far_m, [](std::uint32_t) { return true; });
  if (any_m < lossless_m || std::isinf(any_m)) return any_m;
  return SearchTree_m(p, far_m, [&](std::uint32_t i) { return Contains(nearby, i); });
}

// The nearest that is_meant() holds for, of those nearer than far_m; else infinite.
template <class IsMeant>
double SegmentTree::SearchTree_m(const glm::dvec3& p, double far_m, const IsMeant& is_meant) const {
  double limit_m2 = far_m * far_m;
  double squared_m2 = std::numeric_limits<double>::infinity();
  nearest_.ForNearer(p, &limit_m2, [&](std::uint32_t i) {
    const double here_m2 = SquaredDistance(i, p);
    if (here_m2 >= limit_m2 || !is_meant(i)) return;
    squared_m2 = limit_m2 = here_m2;
  });
  return std::sqrt(squared_m2);
}

bool SegmentTree::Contains(const Nearby& nearby, std::uint32_t item) const {
  if (!Overlap(tree_.nodes[leaf_of_[item]].box, nearby.box)) return false;
  for (const Nearby* set = &nearby; set->outer != nullptr; set = set->outer) {
    if (!(SquaredDistance(item, set->centre) < set->reach_m * set->reach_m)) return false;
  }
  return true;
}

}  // namespace vps
