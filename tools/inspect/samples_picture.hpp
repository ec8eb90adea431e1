#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "picture/image.hpp"
#include "vps/asset/list_structures.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace inspect {

// From four sides, the points that face the viewer: coloured by area over the mean area, or shaded alone. Errors: those
// of Canvas::Create.
core::Result<picture::Image> DrawPoints(const std::string& title, const std::vector<vps::SurfacePoint>& points,
                                        const vps::Box& box);

// A panel for each level: its spheres over the points. Errors: those of Canvas::Create.
core::Result<picture::Image> DrawTree(const std::string& title, const std::vector<std::vector<vps::TreeSphere>>& levels,
                                      const std::vector<vps::SurfacePoint>& points, const vps::Box& box);

}  // namespace inspect
