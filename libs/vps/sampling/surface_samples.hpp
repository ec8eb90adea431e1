#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/fine_block.hpp"

namespace vps {

// With more points than this none is divided further: contacts are seen well enough without, and it would take 192
// bytes each.
constexpr std::uint32_t kMaxFinePoints = 131072;

// Points spread over the surface, denser towards sharp edges and corners, each with the area that it stands for: a sum
// over them is a quadrature over the surface, so that a force neither depends on how many points there are nor jumps
// when one more comes into contact. Mesh frame, metres.
struct SurfaceSamples {
  std::vector<glm::dvec3> points_m;
  // Mean over the surface that the point stands for: shorter than one where that bends or is rough, so that area times
  // normal is its vector area. A unit normal would tell a depth that is even over a rough patch as too large a force.
  std::vector<glm::dvec3> inward_normals;
  std::vector<double> areas_m2;  // sum: the area of the mesh
  std::vector<FineBlock> fine;   // of each point, up to kMaxFinePoints points; else empty
  double reach_m = 0.0;          // no place of the surface is farther from the point that stands for it
};

// What sampling takes at its peak, told from the mesh alone: the number of panels is counted, nothing is built. More
// than kMostSamplingBytes is refused. Errors: no area, too many points.
constexpr double kMostSamplingBytes = 12e9;
core::Result<double> SamplingBytes(const TriangleMesh& mesh, std::uint32_t num_points);

// The surface is cut into panels (MakePanels), about sixty for each point, twenty where there are no finer points.
// Exactly `num_points` of four times as many panels are kept by weighted sample elimination (Yuksel 2015) with radii
// that follow SampleSpacing: blue noise. Every panel then belongs to the nearest point whose normal is within 45
// degrees of its own, so that the faces of an edge keep their own area; points move to the centroid of their panels,
// and once more (Lloyd), and take their mean normal. Areas and vector areas are exact; so is the integral of a depth
// that varies linearly over each cell. (On a surface of radius R the centroid lies inside by spacing^2 / 12 R; what
// that means beside a curved wall the walk puts right.) Deterministic. Errors: no area, too many points, more memory
// than kMostSamplingBytes.
core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points,
                                           const std::function<void(std::string_view, double)>& progress = {});

}  // namespace vps
