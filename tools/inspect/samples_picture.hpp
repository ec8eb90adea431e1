#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "picture/image.hpp"
#include "vps/asset/cooked_object.hpp"

namespace inspect {

// A point of the sampled side.
struct SurfacePoint {
  glm::dvec3 p_m{0.0};
  glm::dvec3 outward{0.0};
  double area_m2 = 0.0;  // quadrature weight; 0: the method has none
};
std::vector<SurfacePoint> PointsOf(const vps::SampleTree& tree);
std::vector<SurfacePoint> PointsOf(const vps::PointTree& tree);

struct TreeSphere {
  glm::dvec3 centre_m{0.0};
  double radius_m = 0.0;
};
// Level by level, the root first.
std::vector<std::vector<TreeSphere>> LevelsOf(const vps::SampleTree& tree);
std::vector<std::vector<TreeSphere>> LevelsOf(const vps::PointTree& tree);

// From four sides, the points that face the viewer: coloured by area over the mean area, or shaded alone. Errors: those
// of Canvas::Create.
core::Result<picture::Image> DrawPoints(const std::string& title, const std::vector<SurfacePoint>& points,
                                        const vps::Box& box);

// A panel for each level: its spheres over the points. Errors: those of Canvas::Create.
core::Result<picture::Image> DrawTree(const std::string& title, const std::vector<std::vector<TreeSphere>>& levels,
                                      const std::vector<SurfacePoint>& points, const vps::Box& box);

}  // namespace inspect
