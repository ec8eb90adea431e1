#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Points spread evenly over the surface, each with the area it stands for: a sum over them is a quadrature over the
// surface, so that a force neither depends on how many points there are nor jumps when one more comes into contact.
// Mesh frame, metres.
struct SurfaceSamples {
  std::vector<glm::dvec3> points_m;
  std::vector<glm::dvec3> inward_normals;
  std::vector<double> areas_m2;  // sum: the area of the mesh
};

// Blue-noise points of BuildPointshell cut the surface into Voronoi cells, measured with kProbesPerPoint times as many
// evenly spread probes: each belongs to the nearest point whose normal is within 45 degrees of its own, so that the
// faces of an edge keep their own area. Every point then moves to the centroid of its cell and takes its mean normal:
// the sum is exact for a depth that varies linearly over a cell. (On a surface of radius R the centroid lies inside by
// spacing^2 / 12 R.) Errors: no area, too many points.
constexpr std::uint32_t kProbesPerPoint = 32;
core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points,
                                           const std::function<void(std::string_view, double)>& progress = {});

}  // namespace vps
