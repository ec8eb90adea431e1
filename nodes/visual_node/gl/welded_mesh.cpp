#include "nodes/visual_node/gl/welded_mesh.hpp"

#include <map>
#include <numeric>

namespace visual_node {

WeldedMesh Weld(const vps::VisualMesh& mesh) {
  WeldedMesh welded;
  std::map<std::array<float, 3>, std::uint32_t> known;
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    std::vector<std::uint32_t> place_of;
    for (const glm::vec3& p : primitive.positions) {
      const auto [it, is_new] = known.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(welded.places.size()));
      if (is_new) welded.places.emplace_back(p);
      place_of.push_back(it->second);
    }
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
      const std::uint32_t* corner = &primitive.indices[i];
      welded.triangles.push_back({place_of[corner[0]], place_of[corner[1]], place_of[corner[2]]});
    }
  }
  return welded;
}

std::vector<std::uint32_t> ConnectedParts(const WeldedMesh& mesh) {
  std::vector<std::uint32_t> part(mesh.places.size());
  std::iota(part.begin(), part.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    part[root(a)] = root(b);
    part[root(b)] = root(c);
  }
  for (std::uint32_t i = 0; i < part.size(); ++i) part[i] = root(i);
  return part;
}

}  // namespace visual_node
