#pragma once

#include "vps/asset/method.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// The thinnest wall of a solid and the narrowest gap between its walls, metres; infinite where there is none.
struct FeatureSize {
  double thickness_m = 0.0;
  glm::dvec3 thinnest_m{0.0};       // middle of that wall, mesh frame
  glm::dvec3 thinnest_normal{0.0};  // across it
  double gap_m = 0.0;
  glm::dvec3 narrowest_m{0.0};  // middle of that gap
  glm::dvec3 narrowest_normal{0.0};
};

// Measured at up to `num_probes` places spread over the surface and as many middles of triangles: the diameter of the
// largest ball that touches the surface there and does not reach through it [shrinking ball, Ma et al. 2012], inside
// for the thickness, outside for the gap. Balls with touching points less than 133 degrees apart sit in an edge or a
// corner and do not count. Features narrower than the probes' spacing can be missed; of those found, the least to 1e-4,
// or to a tenth where very many triangles are about as far (a fine sphere). Takes about a second at most for 100,000
// triangles.
FeatureSize MeasureFeatures(const TriangleMesh& mesh, std::size_t num_probes = 2000);

// What a field with voxels of this size resolves, metres. Derived in the .cpp.
struct FeatureLimits {
  double thickness_m = 0.0;  // a wall this thick has an inside everywhere
  double gap_m = 0.0;        // a gap this wide is free in its middle everywhere
  double clearance_m = 0.0;  // a point this far outside never counts as touching
};
FeatureLimits LimitsOf(Method method, double voxel_size_m);

}  // namespace vps
