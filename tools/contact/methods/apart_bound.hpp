#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/pose.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace contact {

// A surface as a binary tree of boxes, each along the main axes of what it holds; a leaf is one triangle. Mesh frame,
// m.
struct BoxTree {
  using Triangle = std::array<glm::dvec3, 3>;
  struct alignas(64) Node {  // a line of the cache
    glm::vec3 centre_m{0.0f};
    glm::mat3 axes{1.0f};          // columns, unit
    glm::vec3 half_sides_m{0.0f};  // along them
    std::uint32_t below = 0;       // the first of two children side by side; of a leaf: its triangle, and kLeaf
    static constexpr std::uint32_t kLeaf = 1U << 31U;

    [[nodiscard]] bool is_leaf() const { return (below & kLeaf) != 0; }
    [[nodiscard]] std::uint32_t first() const { return below & ~kLeaf; }
  };
  static_assert(sizeof(Node) == 64);
  std::vector<Node> nodes;  // the first is the root; none: no triangles
  std::vector<Triangle> triangles;

  explicit BoxTree(const vps::TriangleMesh& mesh);
};

// How far two surfaces are apart, by their triangles.
class ApartBound {
 public:
  ApartBound(const vps::TriangleMesh& G, const vps::TriangleMesh& S);

  // Conservative lower bound [m] of the distance of the surfaces, within kTolerance of it; 0 where they meet. After
  // kMostPairs pairs what is proven by then.
  //
  // Two convex bodies are apart by at least the gap between their extents along any direction u. Branch and bound over
  // pairs of boxes, the nearest pair first; of two triangles u is that of their nearest places, and the bound exact.
  // The pair of triangles that was nearest in the last call is looked at first: what cannot be nearer is not opened.
  double Query_m(const core::Pose& X_GS);

  // One corner of each connected part of S, in S: where the surfaces do not meet, a part is wholly in G or wholly not.
  [[nodiscard]] const std::vector<glm::dvec3>& corners_of_S_m() const { return corners_of_S_m_; }

  static constexpr double kTolerance = 0.01;  // not derived: pairs opened against looseness
  static constexpr int kMostPairs = 10'000;   // not derived: a few milliseconds

 private:
  struct Pair {
    double bound_m = 0.0;
    std::uint32_t s = 0, g = 0;  // nodes
    // std::push_heap keeps the greatest on top: the nearest pair.
    bool operator<(const Pair& other) const { return bound_m > other.bound_m; }
  };
  class Body;

  // `pair` has its parent's bound.
  void Offer(const Body& body_S, const Body& body_G, Pair pair);
  void MeetTriangles(const BoxTree::Triangle& S, const BoxTree::Triangle& G, const Pair& pair);
  [[nodiscard]] double enough_m() const { return (1.0 - kTolerance) * nearest_m_; }

  BoxTree G_, S_;
  std::vector<glm::dvec3> corners_of_S_m_;
  Pair last_;  // leaves
  // Of a query.
  std::vector<Pair> heap_;
  double nearest_m_ = 0.0;  // of the pairs of triangles met
  double least_m_ = 0.0;    // bound of all pairs that were left unopened, or met
};

}  // namespace contact
