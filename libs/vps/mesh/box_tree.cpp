#include "vps/mesh/box_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace vps {
namespace {

// Most triangles of a leaf. Not derived: fewer cost memory (64 bytes a node), more cost triangle tests.
constexpr std::uint32_t kLeafTriangles = 4;

void Split(const TriangleMesh& mesh, const std::vector<glm::dvec3>& centres, std::uint32_t node, BoxTree* tree) {
  const std::uint32_t first = tree->nodes[node].first;
  const std::uint32_t count = tree->nodes[node].count;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  Box of_centres = box;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const glm::dvec3& corner : mesh.corners(tree->order[i])) {
      box.lower = glm::min(box.lower, corner);
      box.upper = glm::max(box.upper, corner);
    }
    of_centres.lower = glm::min(of_centres.lower, centres[tree->order[i]]);
    of_centres.upper = glm::max(of_centres.upper, centres[tree->order[i]]);
  }
  tree->nodes[node].box = box;
  if (count <= kLeafTriangles) return;
  const glm::dvec3 size = of_centres.upper - of_centres.lower;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const auto begin = tree->order.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
  });
  const auto left = static_cast<std::uint32_t>(tree->nodes.size());
  tree->nodes[node].left = left;
  tree->nodes.resize(tree->nodes.size() + 2);
  tree->nodes[left].first = first;
  tree->nodes[left].count = count / 2;
  tree->nodes[left + 1].first = first + count / 2;
  tree->nodes[left + 1].count = count - count / 2;
  Split(mesh, centres, left, tree);
  Split(mesh, centres, left + 1, tree);
}

}  // namespace

BoxTree BuildBoxTree(const TriangleMesh& mesh) {
  BoxTree tree;
  if (mesh.triangles.empty()) return tree;
  std::vector<glm::dvec3> centres(mesh.triangles.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    centres[i] = (a + b + c) / 3.0;
  }
  tree.order.resize(mesh.triangles.size());
  std::iota(tree.order.begin(), tree.order.end(), 0U);
  tree.nodes.emplace_back();
  tree.nodes[0].count = static_cast<std::uint32_t>(mesh.triangles.size());
  Split(mesh, centres, 0, &tree);
  return tree;
}

}  // namespace vps
