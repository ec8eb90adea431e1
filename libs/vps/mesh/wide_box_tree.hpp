#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace vps {

constexpr int kBoxesPerNode = 8;

// Eight boxes side by side, single precision, rounded outwards; those of unused lanes are farther than any point.
struct WideBoxNode {
  float lower[3][kBoxesPerNode];
  float upper[3][kBoxesPerNode];
  std::uint32_t child[kBoxesPerNode];  // a node, or with kBoxLeaf set an item
};
constexpr std::uint32_t kBoxLeaf = 0x80000000U;

struct FloatBox {
  glm::vec3 lower, upper;  // rounded outwards
};
// Rounded to single precision so that nothing of it is lost.
FloatBox RoundedOutwards(const glm::dvec3& lower, const glm::dvec3& upper);

// Squared distances of a point to the boxes of a node, each no more than the exact one; bit i of the answer: lane i's
// is less than `limit`. `slack`: how much the point's own rounding may have moved it.
std::uint32_t FindNearer(const WideBoxNode& node, const glm::vec3& p, float slack, float limit, float* squared);

// A tree of boxes with one item in each leaf, eight children to a node, all nodes full but those on the left rim. Fewer
// than 2^31 items.
class WideBoxTree {
 public:
  WideBoxTree() = default;
  // Items are numbered as in `boxes`. The same boxes give the same tree.
  explicit WideBoxTree(std::span<const FloatBox> boxes);

  // Calls visit(item) for the items whose box comes nearer to p than *limit (squared distance), nearest boxes first;
  // the visitor may lower the limit. Items are left out only when they are surely no nearer.
  template <class Visit>
  void ForNearer(const glm::dvec3& p, const double* limit, Visit&& visit) const {
    struct Entry {
      std::uint32_t child;
      float squared;
    };
    std::array<Entry, kDeepest * kBoxesPerNode> stack;
    if (nodes_.empty()) return;
    const glm::vec3 point(p);
    const float largest = std::max(std::max(std::abs(point.x), std::abs(point.y)), std::abs(point.z));
    const float slack = largest * 0x1p-22f;  // of rounding p and of the differences
    std::size_t size = 0;
    stack[size++] = {0, 0.0f};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (static_cast<double>(entry.squared) >= *limit) continue;
      if ((entry.child & kBoxLeaf) != 0) {
        visit(entry.child & ~kBoxLeaf);
        continue;
      }
      const WideBoxNode& node = nodes_[entry.child];
      float squared[kBoxesPerNode];
      const std::size_t begin = size;
      std::uint32_t nearer = FindNearer(node, point, slack, static_cast<float>(*limit) * (1.0f + 0x1p-20f), squared);
      for (; nearer != 0; nearer &= nearer - 1) {
        const int i = std::countr_zero(nearer);
        std::size_t at = size++;  // the nearest comes on top
        for (; at > begin && stack[at - 1].squared < squared[i]; --at) stack[at] = stack[at - 1];
        stack[at] = {node.child[i], squared[i]};
      }
    }
  }

 private:
  static constexpr std::size_t kDeepest = 12;  // 8^12 > 2^31
  struct Item {
    glm::vec3 centre;
    std::uint32_t number;
  };
  FloatBox BuildNode(std::uint32_t node, std::span<Item> items, std::span<const FloatBox> boxes);

  std::vector<WideBoxNode> nodes_;
};

}  // namespace vps
