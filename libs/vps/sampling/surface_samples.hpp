#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/pointshell/pointshell.hpp"

namespace vps {

// A quadrature of the surface: points spread evenly, each with the area of its cell (the part of the surface that is
// assigned to it) as weight, so that a force neither depends on the number of points nor jumps when one more comes into
// contact. Mesh frame, metres.
struct SurfaceSamples {
  std::vector<glm::dvec3> points_m;
  // Mean inward normal of the patch, shorter than one where that is curved or rough, so that area times normal is its
  // vector area. Unit normals would overestimate the force of an even depth over a rough patch.
  std::vector<glm::dvec3> inward_normals;
  std::vector<double> areas_m2;  // quadrature weights; their sum is the area of the mesh
  double reach_m = 0.0;          // largest radius of a patch about its point
};

// What is known of a sampling from the mesh alone: panels are counted, nothing is built.
struct SamplingPlan {
  double spacing_m = 0.0;                 // square root of a point's share of the area
  std::vector<std::size_t> panel_begins;  // CountPanels
  double bytes = 0.0;                     // peak memory
};

// Errors: no area, too many points (kInvalidInput), more than kMostSamplingBytes (kResource; the limit is not derived).
constexpr double kMostSamplingBytes = 12e9;
core::Result<SamplingPlan> PlanSampling(const TriangleMesh& mesh, std::uint32_t num_points,
                                        core::ParallelFor* workers = nullptr);

// Blue noise (BuildPointshell), and the surface cut into panels, about twenty for each point. Every panel belongs to a
// point near it, of the same face (FindOwners); points move to the centroid of their panels, and once more (Lloyd), and
// take their mean normal. Areas and vector areas are exact; so is the integral of a depth that varies linearly over
// each cell. Deterministic, with any number of workers. Errors: those of PlanSampling.
core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points,
                                           const std::function<void(std::string_view, double)>& progress = {},
                                           core::ParallelFor* workers = nullptr);

// The second half of it: `plan` is PlanSampling's, `shell` BuildPointshell's, of this mesh and number of points.
SurfaceSamples SpreadSamples(const TriangleMesh& mesh, const SamplingPlan& plan, Pointshell shell,
                             const std::function<void(std::string_view, double)>& progress = {},
                             core::ParallelFor* workers = nullptr);

}  // namespace vps
