#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// A mesh's triangles in a binary tree of boxes.
struct BoxTree {
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // its triangles: order[first .. first + count)
    std::uint32_t left = 0;              // children left and left + 1; 0: a leaf
  };
  std::vector<std::uint32_t> order;
  std::vector<Node> nodes;  // [0] is the root; none for an empty mesh
};

BoxTree BuildBoxTree(const TriangleMesh& mesh);

inline bool Overlap(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
         a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

// Calls visit(triangle) for those in leaves whose boxes overlap `box`.
template <typename Visit>
void ForOverlapping(const BoxTree& tree, const Box& box, Visit&& visit) {
  if (tree.nodes.empty()) return;
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const BoxTree::Node& node = tree.nodes[stack.back()];
    stack.pop_back();
    if (!Overlap(node.box, box)) continue;
    if (node.left != 0) {
      stack.push_back(node.left);
      stack.push_back(node.left + 1);
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(tree.order[i]);
  }
}

}  // namespace vps
