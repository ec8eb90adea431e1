#pragma once

#include <span>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps::oracle {

// Exact signed distance to a closed mesh, in double precision: every triangle's closest point for the magnitude, the
// generalised winding number for the sign. O(triangles) per point, simple, and shares no code with the engine. For
// tests and benchmarks.
class ExactDistance {
 public:
  explicit ExactDistance(const TriangleMesh& mesh);

  // Negative inside, metres.
  [[nodiscard]] double SignedDistance(const glm::dvec3& p) const;
  // How many times the surface winds around p: 1 inside a closed outward-oriented mesh, 0 outside.
  [[nodiscard]] double WindingNumber(const glm::dvec3& p) const;
  [[nodiscard]] double UnsignedDistance(const glm::dvec3& p) const;

 private:
  std::vector<std::array<glm::dvec3, 3>> triangles_;
};

// Closest point of triangle (a, b, c) to p.
glm::dvec3 ClosestPointOnTriangle(const glm::dvec3& p, const std::array<glm::dvec3, 3>& triangle);

}  // namespace vps::oracle
