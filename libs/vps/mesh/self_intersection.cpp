#include "vps/mesh/self_intersection.hpp"

#include <algorithm>
#include <atomic>
#include <optional>

#include "vps/mesh/box_tree.hpp"

namespace vps {
namespace {

// Relative to the triangles' size: an edge that passes a plane by less only touches. Not derived: two roundings of a
// float.
constexpr double kTouch = 1e-7;
// Likewise for coplanarity (angle, and distance over size). Not derived: coarser, since text files hold few digits.
constexpr double kInPlane = 1e-5;

// Where the open segment p q pierces the inside of the triangle.
std::optional<glm::dvec3> Pierce(const glm::dvec3& p, const glm::dvec3& q, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double of_p = glm::dot(n, p - t[0]);
  const double of_q = glm::dot(n, q - t[0]);
  // Both ends on one side, or no area.
  if (!((of_p > 0.0 && of_q < 0.0) || (of_p < 0.0 && of_q > 0.0))) return std::nullopt;
  const double area2 = glm::length(n);
  const double longest = std::max({glm::length(t[1] - t[0]), glm::length(t[2] - t[1]), glm::length(t[0] - t[2])});
  const double hp = of_p / area2;
  const double hq = of_q / area2;
  const double margin = kTouch * std::max(longest, glm::length(q - p));
  if (!((hp > margin && hq < -margin) || (hp < -margin && hq > margin))) return std::nullopt;
  const glm::dvec3 x = p + (hp / (hp - hq)) * (q - p);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 e = t[(k + 1) % 3] - t[k];
    const double inside = glm::dot(glm::cross(n, e), x - t[k]) / (area2 * glm::length(e));  // height over the edge
    if (!(inside > margin)) return std::nullopt;
  }
  return x;
}

std::optional<glm::dvec3> Cross(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const auto corners_a = mesh.corners(a);
  const auto corners_b = mesh.corners(b);
  for (int k = 0; k < 3; ++k) {
    if (const auto x = Pierce(corners_a[k], corners_a[(k + 1) % 3], corners_b)) return x;
    if (const auto x = Pierce(corners_b[k], corners_b[(k + 1) % 3], corners_a)) return x;
  }
  return std::nullopt;
}

int SharedVertices(const std::array<std::uint32_t, 3>& a, const std::array<std::uint32_t, 3>& b) {
  int shared = 0;
  for (const std::uint32_t v : a) shared += v == b[0] || v == b[1] || v == b[2] ? 1 : 0;
  return shared;
}

Box BoxOf(const TriangleMesh& mesh, std::uint32_t t) {
  const auto [a, b, c] = mesh.corners(t);
  return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
}

glm::dvec3 UnitNormal(const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

// Whether both lie in one plane and share an area there: no edge of either has all of the other on its outer side.
bool LieOnEachOther(const std::array<glm::dvec3, 3>& a, const std::array<glm::dvec3, 3>& b) {
  const std::array<glm::dvec3, 2> normals{UnitNormal(a), UnitNormal(b)};
  if (!(std::abs(glm::dot(normals[0], normals[1])) > 1.0 - kInPlane)) return false;
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max({longest, glm::length(a[(k + 1) % 3] - a[k]), glm::length(b[(k + 1) % 3] - b[k])});
  }
  const double margin = kInPlane * longest;
  for (const glm::dvec3& q : b) {
    if (std::abs(glm::dot(normals[0], q - a[0])) > margin) return false;
  }
  const auto has_all_outside = [margin](const std::array<glm::dvec3, 3>& t, const glm::dvec3& n,
                                        const std::array<glm::dvec3, 3>& other) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 inwards = glm::cross(n, glm::normalize(t[(k + 1) % 3] - t[k]));
      double farthest_in = -1e300;
      for (const glm::dvec3& q : other) farthest_in = std::max(farthest_in, glm::dot(inwards, q - t[k]));
      if (farthest_in <= margin) return true;
    }
    return false;
  };
  return !has_all_outside(a, normals[0], b) && !has_all_outside(b, normals[1], a);
}

constexpr std::size_t kTrianglesOfBlock = 256;  // free: enough blocks for all workers

// Pairs of triangles whose boxes overlap or touch, by blocks of the first one of each pair.
class NearPairs {
 public:
  explicit NearPairs(const TriangleMesh& mesh) : mesh_(mesh), tree_(BuildBoxTree(mesh)) {}

  [[nodiscard]] std::size_t num_blocks() const {
    return (mesh_.triangles.size() + kTrianglesOfBlock - 1) / kTrianglesOfBlock;
  }

  // Calls visit(a, b), a < b, in order; ends when it returns false.
  template <typename Visit>
  void ForBlock(std::size_t block, Visit&& visit) const {
    std::vector<std::uint32_t> near;
    const std::size_t end = std::min((block + 1) * kTrianglesOfBlock, mesh_.triangles.size());
    for (auto a = static_cast<std::uint32_t>(block * kTrianglesOfBlock); a < end; ++a) {
      Box box = BoxOf(mesh_, a);
      const double margin = kInPlane * glm::length(box.upper - box.lower);
      box = {box.lower - margin, box.upper + margin};
      near.clear();
      ForOverlapping(tree_, box, [&](std::uint32_t b) {
        if (b > a && Overlap(box, BoxOf(mesh_, b))) near.push_back(b);
      });
      std::sort(near.begin(), near.end());
      for (const std::uint32_t b : near) {
        if (!visit(a, b)) return;
      }
    }
  }

 private:
  const TriangleMesh& mesh_;
  BoxTree tree_;
};

bool Intersect(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  if (LieOnEachOther(mesh.corners(a), mesh.corners(b))) return true;
  return SharedVertices(mesh.triangles[a], mesh.triangles[b]) < 2 && Cross(mesh, a, b).has_value();
}

}  // namespace

std::vector<Crossing> FindCrossings(const TriangleMesh& mesh, std::size_t max_crossings, core::ParallelFor* workers) {
  const NearPairs pairs(mesh);
  constexpr std::size_t kBlocksAtOnce = 64;  // free: no more is searched in vain once there are enough
  std::vector<Crossing> crossings;
  for (std::size_t first = 0; first < pairs.num_blocks() && crossings.size() < max_crossings; first += kBlocksAtOnce) {
    std::vector<std::vector<Crossing>> found(std::min(kBlocksAtOnce, pairs.num_blocks() - first));
    core::ForEach(workers, found.size(), [&](std::size_t i) {
      pairs.ForBlock(first + i, [&](std::uint32_t a, std::uint32_t b) {
        if (SharedVertices(mesh.triangles[a], mesh.triangles[b]) < 2) {
          if (const auto x = Cross(mesh, a, b)) found[i].push_back({a, b, *x});
        }
        return found[i].size() < max_crossings;
      });
    });
    for (const auto& of_block : found) crossings.insert(crossings.end(), of_block.begin(), of_block.end());
  }
  if (crossings.size() > max_crossings) crossings.resize(max_crossings);
  return crossings;
}

std::vector<std::uint8_t> FindIntersectingTriangles(const TriangleMesh& mesh, core::ParallelFor* workers) {
  const NearPairs pairs(mesh);
  // A pair of which both are marked already needs no test, whichever worker has marked them.
  std::vector<std::atomic<std::uint8_t>> is_marked(mesh.triangles.size());
  core::ForEach(workers, pairs.num_blocks(), [&](std::size_t block) {
    pairs.ForBlock(block, [&](std::uint32_t a, std::uint32_t b) {
      const bool is_known =
          is_marked[a].load(std::memory_order_relaxed) != 0 && is_marked[b].load(std::memory_order_relaxed) != 0;
      if (!is_known && Intersect(mesh, a, b)) {
        is_marked[a].store(1, std::memory_order_relaxed);
        is_marked[b].store(1, std::memory_order_relaxed);
      }
      return true;
    });
  });
  return {is_marked.begin(), is_marked.end()};
}

bool HasSelfIntersection(const TriangleMesh& mesh, core::ParallelFor* workers) {
  const NearPairs pairs(mesh);
  std::atomic<bool> is_intersecting = false;
  core::ForEach(workers, pairs.num_blocks(), [&](std::size_t block) {
    pairs.ForBlock(block, [&](std::uint32_t a, std::uint32_t b) {
      if (is_intersecting.load(std::memory_order_relaxed)) return false;
      if (Intersect(mesh, a, b)) is_intersecting.store(true, std::memory_order_relaxed);
      return true;
    });
  });
  return is_intersecting;
}

}  // namespace vps
