#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"
#include "vps/oracle/triangle.hpp"

namespace vps::oracle {

// ExactDistance from a tree of boxes, in double precision: O(log triangles) per point. Mesh frame, m.
class MeshDistance {
 public:
  // kSolid: inside where the winding number exceeds 1/2, so that small holes do no harm. kSheet: an
  // open surface with two sides and no inside, every distance is positive.
  enum class Sides { kSolid, kSheet };

  explicit MeshDistance(const TriangleMesh& mesh, Sides sides = Sides::kSolid);

  // Negative inside. Exact to rounding.
  [[nodiscard]] double SignedDistance(const glm::dvec3& p) const;
  [[nodiscard]] double UnsignedDistance(const glm::dvec3& p) const;
  [[nodiscard]] bool IsInside(const glm::dvec3& p) const;
  // Sum over all triangles, exact to rounding; O(triangles).
  [[nodiscard]] double WindingNumber(const glm::dvec3& p) const;

  struct Nearest {
    double distance_m = 0.0;
    std::uint32_t triangle = 0;  // index into triangles()
    glm::dvec3 point_m{0.0};
  };
  // Nullopt when no surface point is nearer than `limit_m`.
  [[nodiscard]] std::optional<Nearest> FindNearest(const glm::dvec3& p,
                                                   double limit_m = std::numeric_limits<double>::infinity()) const;
  // Does any triangle share a point with `t`? `skip_neighbours`: none that shares a corner with it counts.
  [[nodiscard]] bool Meets(const Triangle& t, bool skip_neighbours = false) const;
  // The triangles, grouped by neighbourhood.
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
  [[nodiscard]] bool has_inside() const { return sides_ == Sides::kSolid; }

  // A node holds triangles [first, first + count); its children, when it has any, are `left` and `left + 1`.
  struct Node {
    glm::dvec3 lower_m{0.0}, upper_m{0.0};
    glm::dvec3 centre_m{0.0};   // area-weighted centroid: centre of the far field and of the sphere
    double radius_m = 0.0;      // sphere around centre_m that holds the triangles
    glm::dvec3 dipole_m2{0.0};  // sum of area times normal
    std::uint32_t first = 0, count = 0;
    std::uint32_t left = 0;  // 0: a leaf
  };
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }  // [0] is the root
  // One corner of each connected part.
  [[nodiscard]] const std::vector<glm::dvec3>& part_corners() const { return part_corners_; }

 private:
  // Angle-weighted normals of a triangle's edges (k: from corner k to k + 1) and corners, outwards, of any length.
  struct Normals {
    std::array<glm::dvec3, 3> edge, corner;
  };

  void Build(std::uint32_t node, const TriangleMesh& mesh, std::vector<std::uint32_t>* order);
  void FindParts(const TriangleMesh& mesh);
  [[nodiscard]] bool IsSimpleSolid(const TriangleMesh& mesh) const;
  void ComputeNormals(const TriangleMesh& mesh, const std::vector<std::uint32_t>& order);
  [[nodiscard]] bool IsInside(const glm::dvec3& p, const Nearest& nearest) const;
  [[nodiscard]] double FarFieldWinding(const glm::dvec3& p) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  std::vector<glm::dvec3> part_corners_;
  std::vector<glm::dvec3> part_centroids_;  // of one triangle of each part
  std::vector<Normals> normals_;            // of a simple solid
  Sides sides_;
  bool is_simple_solid_ = false;  // closed, oriented, free of self-intersection: normals determine inside and outside
};

}  // namespace vps::oracle
