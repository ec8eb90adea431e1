#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "vps/mesh/box_tree.hpp"
#include "vps/mesh/wide_box_tree.hpp"

namespace vps {

// Segments in a tree of boxes; a point is a segment without length.
class SegmentTree {
 public:
  explicit SegmentTree(std::vector<std::array<glm::dvec3, 2>> segments);

  // Those that may matter to a piece of surface, narrowed down while it is divided: the ones in leaves around a box,
  // and of those the ones that come within a reach of each of some centres. Few are listed, many are looked for in the
  // tree: a fine mesh has thousands around a triangle, and most triangles are not divided. `outer` has to outlive it.
  struct Nearby {
    const Nearby* outer = nullptr;  // the set before it was narrowed; null: `box`
    Box box;
    glm::dvec3 centre{0.0};
    double reach_m = 0.0;
    bool is_listed = false;
    std::vector<std::uint32_t> items;
    double listless_m = std::numeric_limits<double>::infinity();  // last reach for which a list was too long
    [[nodiscard]] bool is_empty() const { return is_listed && items.empty(); }
  };
  [[nodiscard]] Nearby Around(const Box& box) const;
  [[nodiscard]] Nearby Narrow(const Nearby& nearby, const glm::dvec3& centre, double reach_m) const;

  // The distance from p to the nearest of the set, infinite when it is empty. `lossless_m`: up to this distance from p
  // narrowing has kept what is nearest; `far_m`: all distances from this one on are as good as infinite.
  [[nodiscard]] double Distance_m(const glm::dvec3& p, const Nearby& nearby, double lossless_m, double far_m) const;

 private:
  [[nodiscard]] double SquaredDistance(std::uint32_t item, const glm::dvec3& p) const;
  [[nodiscard]] bool ListOverlapping(const Box& box, std::vector<std::uint32_t>* items) const;
  [[nodiscard]] bool Contains(const Nearby& nearby, std::uint32_t item) const;
  template <class IsMeant>
  [[nodiscard]] double SearchTree_m(const glm::dvec3& p, double far_m, const IsMeant& is_meant) const;

  std::vector<std::array<glm::dvec3, 2>> segments_;
  BoxTree tree_;                        // for boxes
  WideBoxTree nearest_;                 // for places
  std::vector<std::uint32_t> leaf_of_;  // of each segment, in tree_
};

}  // namespace vps
