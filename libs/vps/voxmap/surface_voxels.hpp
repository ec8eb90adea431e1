#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "vps/mesh/triangle_mesh.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// Triangle against unit cubes of the integer lattice: the separating-axis test in the form of edge functions
// (Schwarz and Seidel 2010). The 13 axes fall into three groups: the plane's normal (a slab), the coordinate axes
// (the box of the triangle) and the nine cross products, which are the edges' normals in the three axis-parallel
// projections. Everything that does not depend on the cube is computed once.
class TriangleCubeTest {
 public:
  // Corners in voxel units: cube (x,y,z) spans [x,x+1] x [y,y+1] x [z,z+1].
  TriangleCubeTest(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

  // Cubes that the triangle's box touches, both ends included.
  [[nodiscard]] glm::ivec3 lower() const { return lower_; }
  [[nodiscard]] glm::ivec3 upper() const { return upper_; }
  // Axis along which the normal is longest: the slab is thinnest in its direction.
  [[nodiscard]] int dominant_axis() const { return dominant_; }
  // Range of cubes along the dominant axis that the plane can touch in the column through `cube`.
  void ColumnRange(const glm::ivec3& cube, int* first, int* last) const;
  [[nodiscard]] bool Touches(const glm::ivec3& cube) const;

 private:
  struct EdgeFunction {
    double a, b, d;
  };
  glm::dvec3 normal_;
  double plane_lower_, plane_upper_;  // normal . cube must lie between
  EdgeFunction edges_[3][3];          // [projection][edge]
  glm::ivec3 lower_, upper_;
  int dominant_ = 2;
  bool is_degenerate_ = false;
};

// Marks every voxel of the grid that a triangle touches: state[voxel] = mark.
void MarkSurface(const TriangleMesh& mesh, const Voxmap& grid, std::uint8_t mark, std::uint8_t* state);

}  // namespace vps
