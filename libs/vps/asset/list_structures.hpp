#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// What an object's structures are made of, listed to be drawn: points, spheres and voxels of either method. Mesh frame.

struct SurfacePoint {
  glm::dvec3 p_m{0.0};
  glm::dvec3 outward{0.0};
  double area_m2 = 0.0;  // quadrature weight; 0: the method has none
};
std::vector<SurfacePoint> PointsOf(const SampleTree& tree);
std::vector<SurfacePoint> PointsOf(const PointTree& tree);

struct TreeSphere {
  glm::dvec3 centre_m{0.0};
  double radius_m = 0.0;
};
// Level by level, the root first.
std::vector<std::vector<TreeSphere>> LevelsOf(const SampleTree& tree);
std::vector<std::vector<TreeSphere>> LevelsOf(const PointTree& tree);

// Centres of the voxels through which the surface passes: of a field those whose cube its tangent plane cuts.
std::vector<glm::vec3> SurfaceVoxelsOf(const DistanceField& field);
std::vector<glm::vec3> SurfaceVoxelsOf(const Voxmap& map);

}  // namespace vps
