#include "vps/mesh/stitch_border.hpp"

#include <algorithm>
#include <numeric>

#include "vps/mesh/edge_table.hpp"

namespace vps {
namespace {

struct Border {
  std::vector<EdgeUse> edges;          // with one triangle
  std::vector<std::uint32_t> corners;  // of them, by x
};

Border FindBorder(const TriangleMesh& mesh) {
  Border border;
  const std::vector<EdgeUse> edges = SortedEdges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    if (end - i == 1) {
      border.edges.push_back(edges[i]);
      border.corners.push_back(static_cast<std::uint32_t>(edges[i].key >> 32));
      border.corners.push_back(static_cast<std::uint32_t>(edges[i].key));
    }
    i = end;
  }
  std::sort(border.corners.begin(), border.corners.end());
  border.corners.erase(std::unique(border.corners.begin(), border.corners.end()), border.corners.end());
  const auto& p = mesh.vertices;
  std::stable_sort(border.corners.begin(), border.corners.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return p[a].x < p[b].x; });
  return border;
}

}  // namespace

std::size_t WeldBorder(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin) {
  const std::vector<std::uint32_t> by_x = FindBorder(*mesh).corners;
  const auto& p = mesh->vertices;
  std::vector<std::uint32_t> target(p.size());
  std::iota(target.begin(), target.end(), 0U);
  std::size_t num_welded = 0;
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    if (target[by_x[i]] != by_x[i]) continue;
    for (std::size_t j = i + 1; j < by_x.size() && p[by_x[j]].x - p[by_x[i]].x <= reach_m; ++j) {
      if (target[by_x[j]] != by_x[j] || glm::length(p[by_x[j]] - p[by_x[i]]) > reach_m) continue;
      target[by_x[j]] = by_x[i];
      ++num_welded;
    }
  }
  if (num_welded == 0) return 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh->triangles.size(); ++i) {
    auto t = mesh->triangles[i];
    for (std::uint32_t& v : t) v = target[v];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    mesh->triangles[kept] = t;
    (*origin)[kept++] = (*origin)[i];
  }
  mesh->triangles.resize(kept);
  origin->resize(kept);
  return num_welded;
}

std::size_t SplitAtBorderCorners(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin) {
  std::size_t num_splits = 0;
  // A pass splits each triangle at one of its edges; the next takes its other edges.
  for (int pass = 0; pass < 3; ++pass) {
    const Border border = FindBorder(*mesh);
    const auto& p = mesh->vertices;
    const std::size_t before = num_splits;
    std::vector<std::uint8_t> is_split(mesh->triangles.size(), 0);
    for (const EdgeUse& edge : border.edges) {
      if (is_split[edge.triangle] != 0) continue;
      const auto t = mesh->triangles[edge.triangle];
      const std::uint32_t a = t[edge.corner];
      const std::uint32_t b = t[(edge.corner + 1) % 3];
      const std::uint32_t c = t[(edge.corner + 2) % 3];
      const glm::dvec3 along = p[b] - p[a];
      const double length = glm::length(along);
      const double low = std::min(p[a].x, p[b].x) - reach_m;
      const double high = std::max(p[a].x, p[b].x) + reach_m;
      std::vector<std::pair<double, std::uint32_t>> between;
      for (auto it = std::lower_bound(border.corners.begin(), border.corners.end(), low,
                                      [&](std::uint32_t v, double x) { return p[v].x < x; });
           it != border.corners.end() && p[*it].x <= high; ++it) {
        const double s = glm::dot(p[*it] - p[a], along) / (length * length);
        if (*it == a || *it == b || *it == c || s * length <= reach_m || (1.0 - s) * length <= reach_m) continue;
        if (glm::length(p[*it] - p[a] - s * along) <= reach_m) between.emplace_back(s, *it);
      }
      if (between.empty()) continue;
      std::sort(between.begin(), between.end());
      is_split[edge.triangle] = 1;
      num_splits += between.size();
      mesh->triangles[edge.triangle] = {a, between[0].second, c};
      for (std::size_t i = 0; i < between.size(); ++i) {
        mesh->triangles.push_back({between[i].second, i + 1 < between.size() ? between[i + 1].second : b, c});
        origin->push_back((*origin)[edge.triangle]);
      }
    }
    if (num_splits == before) break;
  }
  return num_splits;
}

}  // namespace vps
