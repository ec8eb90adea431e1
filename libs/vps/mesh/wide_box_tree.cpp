#include "vps/mesh/wide_box_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();

// Splits a range into compact pieces of `unit` items; the last may be smaller.
template <class Item, class Visit>
void Part(std::span<Item> items, std::size_t unit, const Visit& visit) {
  const std::size_t num_units = (items.size() + unit - 1) / unit;
  if (num_units <= 1) {
    if (!items.empty()) visit(items);
    return;
  }
  glm::vec3 lower(kFar);
  glm::vec3 upper(-kFar);
  for (const Item& item : items) {
    lower = glm::min(lower, item.centre);
    upper = glm::max(upper, item.centre);
  }
  const glm::vec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::size_t middle = num_units / 2 * unit;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                   [axis](const Item& a, const Item& b) {
                     return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.number < b.number;
                   });
  Part(items.first(middle), unit, visit);
  Part(items.subspan(middle), unit, visit);
}

}  // namespace

FloatBox RoundedOutwards(const glm::dvec3& lower, const glm::dvec3& upper) {
  FloatBox box{glm::vec3(lower), glm::vec3(upper)};
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = std::nextafter(box.lower[axis], -kFar);
    box.upper[axis] = std::nextafter(box.upper[axis], kFar);
  }
  return box;
}

VPS_WIDE_CLONES std::uint32_t FindNearer(const WideBoxNode& node, const glm::vec3& p, float slack, float limit,
                                         float* squared) {
  using Lanes = float __attribute__((vector_size(kBoxesPerNode * sizeof(float))));
  Lanes sum{};
  for (int axis = 0; axis < 3; ++axis) {
    Lanes lower, upper;
    __builtin_memcpy(&lower, node.lower[axis], sizeof lower);
    __builtin_memcpy(&upper, node.upper[axis], sizeof upper);
    const Lanes below = lower - p[axis];
    const Lanes above = p[axis] - upper;
    Lanes out = (below > above ? below : above) - slack;
    out = out > 0.0f ? out : Lanes{};
    sum += out * out;
  }
  constexpr float kLess = 1.0f - 0x1p-20f;  // than what the sum's roundings may have added
  sum *= kLess;
  __builtin_memcpy(squared, &sum, sizeof sum);
  using Bits = std::int32_t __attribute__((vector_size(kBoxesPerNode * sizeof(std::int32_t))));
  constexpr Bits kLaneBits = {1, 2, 4, 8, 16, 32, 64, 128};
  const Bits bits = (sum < limit) & kLaneBits;
  std::uint32_t nearer = 0;
  for (int i = 0; i < kBoxesPerNode; ++i) nearer |= static_cast<std::uint32_t>(bits[i]);
  return nearer;
}

WideBoxTree::WideBoxTree(std::span<const FloatBox> boxes) {
  if (boxes.empty()) return;
  std::vector<Item> items(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) items[i] = {0.5f * (boxes[i].lower + boxes[i].upper), i};
  nodes_.reserve(boxes.size() / (kBoxesPerNode - 1) + kDeepest);
  nodes_.emplace_back();
  BuildNode(0, items, boxes);
}

FloatBox WideBoxTree::BuildNode(std::uint32_t node, std::span<Item> items, std::span<const FloatBox> boxes) {
  std::size_t unit = 1;
  while (unit * kBoxesPerNode < items.size()) unit *= kBoxesPerNode;
  FloatBox all{glm::vec3(kFar), glm::vec3(-kFar)};
  int lane = 0;
  const auto put = [&](const FloatBox& box, std::uint32_t child) {
    for (int axis = 0; axis < 3; ++axis) {
      nodes_[node].lower[axis][lane] = box.lower[axis];
      nodes_[node].upper[axis][lane] = box.upper[axis];
    }
    nodes_[node].child[lane++] = child;
    all = {glm::min(all.lower, box.lower), glm::max(all.upper, box.upper)};
  };
  Part(items, unit, [&](std::span<Item> part) {
    if (part.size() == 1) {
      put(boxes[part[0].number], part[0].number | kBoxLeaf);
      return;
    }
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    put(BuildNode(child, part, boxes), child);
  });
  const FloatBox whole = all;
  while (lane < kBoxesPerNode) put({glm::vec3(kFar), glm::vec3(-kFar)}, kBoxLeaf);
  return whole;
}

}  // namespace vps
