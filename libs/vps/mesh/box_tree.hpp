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

}  // namespace vps
