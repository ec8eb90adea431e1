#include "vps/mesh/edge_table.hpp"

#include <algorithm>
#include <cstdlib>

namespace vps {

std::vector<EdgeUse> SortedEdges(const TriangleMesh& mesh) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint64_t a = mesh.triangles[i][k];
      const std::uint64_t b = mesh.triangles[i][(k + 1) % 3];
      edges.push_back({a < b ? (a << 32 | b) : (b << 32 | a), i, k, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
  });
  return edges;
}

std::size_t EndOfEdge(const std::vector<EdgeUse>& edges, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < edges.size() && edges[end].key == edges[begin].key) ++end;
  return end;
}

std::vector<std::vector<std::uint32_t>> BoundaryLoops(const TriangleMesh& mesh) {
  struct Step {
    std::uint32_t from, to;
    bool is_used = false;
  };
  std::vector<Step> steps;
  const std::vector<EdgeUse> edges = SortedEdges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    int net = 0;
    for (std::size_t j = i; j < end; ++j) net += edges[j].is_forward ? 1 : -1;
    const auto low = static_cast<std::uint32_t>(edges[i].key >> 32);
    const auto high = static_cast<std::uint32_t>(edges[i].key);
    for (int n = 0; n < std::abs(net); ++n) steps.push_back(net > 0 ? Step{low, high} : Step{high, low});
    i = end;
  }
  std::sort(steps.begin(), steps.end(),
            [](const Step& a, const Step& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  // Every vertex has as many outgoing as incoming steps, so that a walk ends where it began; where it meets a vertex
  // for the second time, the loop between is cut out.
  std::vector<std::vector<std::uint32_t>> loops;
  std::vector<std::int64_t> place(mesh.vertices.size(), -1);  // in the walk
  for (Step& first : steps) {
    if (first.is_used) continue;
    std::vector<std::uint32_t> walk;
    std::uint32_t v = first.from;
    for (;;) {
      if (place[v] >= 0) {
        const auto begin = walk.begin() + place[v];
        loops.emplace_back(begin, walk.end());
        for (auto it = begin; it != walk.end(); ++it) place[*it] = -1;
        walk.erase(begin, walk.end());
      }
      const auto next = std::find_if(
          std::lower_bound(steps.begin(), steps.end(), v, [](const Step& s, std::uint32_t w) { return s.from < w; }),
          steps.end(), [&](const Step& s) { return s.from != v || !s.is_used; });
      if (next == steps.end() || next->from != v) break;
      next->is_used = true;
      place[v] = static_cast<std::int64_t>(walk.size());
      walk.push_back(v);
      v = next->to;
    }
  }
  return loops;
}

}  // namespace vps
