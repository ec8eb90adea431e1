#include "vps/tree/build_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vps/mesh/triangle_mesh.hpp"
#include "vps/pointshell/point_grid.hpp"

namespace vps {
namespace {

constexpr int kChildren = 4;  // K
// How far a cluster may reach, in mean spacings of its level. Not derived: with 3 about one cluster in twenty has fewer
// than four children (test PointTree.MostClustersHoldFour); less makes more of them, more makes wider spheres.
constexpr double kReachSpacings = 3.0;

struct Group {
  std::array<std::uint32_t, kChildren> members{};
  int count = 0;
};

std::uint64_t SpreadBits(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  v = (v | v << 2) & 0x1249249249249249ULL;
  return v;
}

// Indices along a Morton curve: clusters are taken from one end to the other, so few points are left isolated.
std::vector<std::uint32_t> MortonOrder(const std::vector<glm::dvec3>& points) {
  glm::dvec3 low = points[0];
  glm::dvec3 high = points[0];
  for (const auto& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-12});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 q = (points[i] - low) / extent * 2097151.0;
    keys.emplace_back(SpreadBits(static_cast<std::uint64_t>(q.x)) | SpreadBits(static_cast<std::uint64_t>(q.y)) << 1 |
                          SpreadBits(static_cast<std::uint64_t>(q.z)) << 2,
                      i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  for (const auto& key : keys) order.push_back(key.second);
  return order;
}

// Mean distance to the nearest neighbour, from a sample of the points.
double MeanSpacing(const std::vector<glm::dvec3>& points, const PointGrid& grid, double cell) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / 256);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    double best = std::numeric_limits<double>::infinity();
    for (int ring = 0; ring < 64 && !(best < (ring - 1) * cell); ++ring) {
      grid.ForRing(grid.CellOf(points[i]), ring, [&](std::uint32_t j) {
        if (j != i) best = std::min(best, glm::length(points[j] - points[i]));
      });
    }
    if (std::isfinite(best)) {
      sum += best;
      ++count;
    }
  }
  return count > 0 ? sum / count : cell;
}

std::vector<Group> ClusterLevel(const std::vector<glm::dvec3>& points) {
  std::vector<Group> groups;
  const auto order = MortonOrder(points);
  if (points.size() <= kChildren) {
    Group all;
    for (const std::uint32_t i : order) all.members[all.count++] = i;
    groups.push_back(all);
    return groups;
  }
  glm::dvec3 low = points[0];
  glm::dvec3 high = points[0];
  for (const auto& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  // On a surface n points stand about extent / sqrt(n) apart: good enough for the cell size of the search.
  const double cell = std::max(glm::length(high - low) / std::sqrt(static_cast<double>(points.size())), 1e-9);
  const PointGrid grid(points, cell);
  const double spacing = MeanSpacing(points, grid, cell);
  // With few points left the level is coarse against the object's shape and any reach is fine.
  const double reach = points.size() <= 64 ? std::numeric_limits<double>::infinity() : kReachSpacings * spacing;
  const int max_ring =
      points.size() <= 64 ? static_cast<int>(glm::length(high - low) / cell) + 2 : static_cast<int>(reach / cell) + 1;
  std::vector<std::uint8_t> is_taken(points.size(), 0);
  for (const std::uint32_t seed : order) {
    if (is_taken[seed]) continue;
    is_taken[seed] = 1;
    std::array<std::pair<double, std::uint32_t>, kChildren - 1> nearest;
    nearest.fill({std::numeric_limits<double>::infinity(), 0xffffffffU});
    const glm::ivec3 home = grid.CellOf(points[seed]);
    for (int ring = 0; ring <= max_ring; ++ring) {
      if (nearest.back().first <= (ring - 1) * cell) break;  // nothing in this ring can be closer
      grid.ForRing(home, ring, [&](std::uint32_t j) {
        if (is_taken[j]) return;
        const std::pair<double, std::uint32_t> candidate{glm::length(points[j] - points[seed]), j};
        if (candidate.first > reach || !(candidate < nearest.back())) return;
        nearest.back() = candidate;
        std::sort(nearest.begin(), nearest.end());
      });
    }
    Group group;
    group.members[group.count++] = seed;
    for (const auto& [distance, j] : nearest) {
      if (j == 0xffffffffU) continue;
      group.members[group.count++] = j;
      is_taken[j] = 1;
    }
    groups.push_back(group);
  }
  return groups;
}

// The member nearest to the members' centre of mass.
std::uint32_t ParentOf(const Group& group, const std::vector<glm::dvec3>& points) {
  glm::dvec3 centre(0.0);
  for (int k = 0; k < group.count; ++k) centre += points[group.members[k]] / static_cast<double>(group.count);
  std::uint32_t best = group.members[0];
  for (int k = 1; k < group.count; ++k) {
    if (glm::length(points[group.members[k]] - centre) < glm::length(points[best] - centre)) best = group.members[k];
  }
  return best;
}

}  // namespace

PointTree BuildTree(const Pointshell& shell) {
  PointTree tree;
  tree.num_points = static_cast<std::uint32_t>(shell.points_m.size());
  if (tree.num_points == 0) return tree;

  // levels[0] groups points; levels[l] groups the groups of levels[l - 1], through their parent points.
  std::vector<std::vector<Group>> levels;
  std::vector<std::vector<std::uint32_t>> parents;  // parents[l][g]: point index in the shell
  std::vector<std::uint32_t> level_points(tree.num_points);
  for (std::uint32_t i = 0; i < tree.num_points; ++i) level_points[i] = i;
  do {
    std::vector<glm::dvec3> positions;
    for (const std::uint32_t p : level_points) positions.push_back(shell.points_m[p]);
    levels.push_back(ClusterLevel(positions));
    std::vector<std::uint32_t> next;
    for (const Group& group : levels.back()) next.push_back(level_points[ParentOf(group, positions)]);
    parents.push_back(next);
    level_points = std::move(next);
  } while (level_points.size() > 1);

  // Breadth-first from the root: the children of a cluster, and the points of a leaf, come to stand side by side.
  std::vector<std::uint32_t> order;  // shell index of tree point i
  std::vector<std::uint32_t> level_groups{0};
  std::vector<std::uint32_t> parent_shell_index;
  for (std::size_t l = levels.size(); l-- > 0;) {
    std::vector<std::uint32_t> next;
    const std::size_t first_of_next_level = tree.clusters.size() + level_groups.size();
    for (const std::uint32_t g : level_groups) {
      const Group& group = levels[l][g];
      Cluster cluster;
      cluster.num_children = static_cast<std::uint8_t>(group.count);
      cluster.is_leaf = l == 0 ? 1 : 0;
      cluster.first_child =
          static_cast<std::uint32_t>(l == 0 ? order.size() + next.size() : first_of_next_level + next.size());
      tree.clusters.push_back(cluster);
      parent_shell_index.push_back(parents[l][g]);
      next.insert(next.end(), group.members.begin(), group.members.begin() + group.count);
    }
    if (l == 0) order = next;
    level_groups = std::move(next);
  }

  const auto resize = [&](std::vector<float>* v) { v->assign(tree.num_points + PointTree::kPadding, 0.0f); };
  for (auto* v : {&tree.x, &tree.y, &tree.z, &tree.nx, &tree.ny, &tree.nz}) resize(v);
  std::vector<std::uint32_t> tree_index(tree.num_points);
  for (std::uint32_t i = 0; i < tree.num_points; ++i) {
    const std::uint32_t source = order[i];
    tree_index[source] = i;
    tree.x[i] = static_cast<float>(shell.points_m[source].x);
    tree.y[i] = static_cast<float>(shell.points_m[source].y);
    tree.z[i] = static_cast<float>(shell.points_m[source].z);
    tree.nx[i] = static_cast<float>(shell.inward_normals[source].x);
    tree.ny[i] = static_cast<float>(shell.inward_normals[source].y);
    tree.nz[i] = static_cast<float>(shell.inward_normals[source].z);
  }
  // Children stand behind their parents, so from the back every cluster finds its children done. The points below a
  // cluster are one run, from the first leaf's first point.
  std::vector<std::uint32_t> first_point(tree.clusters.size());
  for (std::size_t i = tree.clusters.size(); i-- > 0;) {
    Cluster& cluster = tree.clusters[i];
    cluster.parent_point = tree_index[parent_shell_index[i]];
    if (cluster.is_leaf) {
      first_point[i] = cluster.first_child;
      cluster.num_points = cluster.num_children;
    } else {
      first_point[i] = first_point[cluster.first_child];
      for (std::uint32_t k = 0; k < cluster.num_children; ++k) {
        cluster.num_points += tree.clusters[cluster.first_child + k].num_points;
      }
    }
    const std::uint32_t first = first_point[i];
    const Sphere sphere =
        SmallestSphere(tree.x.data() + first, tree.y.data() + first, tree.z.data() + first, cluster.num_points);
    double radius = 0.0;  // around the centre as it is stored
    for (int k = 0; k < 3; ++k) cluster.centre_m[k] = static_cast<float>(sphere.centre[k]);
    for (std::uint32_t k = first; k < first + cluster.num_points; ++k) {
      const glm::dvec3 r(double(tree.x[k]) - cluster.centre_m[0], double(tree.y[k]) - cluster.centre_m[1],
                         double(tree.z[k]) - cluster.centre_m[2]);
      radius = std::max(radius, glm::length(r));
    }
    cluster.radius_m = static_cast<float>(radius * (1.0 + 1e-6)) + 1e-9f;
  }
  return tree;
}

}  // namespace vps
