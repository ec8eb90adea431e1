#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Points spread evenly over the surface, with unit normals that point inwards [VR-OOS, section 3, Fig. 5b].
// Expressed in the mesh frame. (The paper's origin is the centre of mass; the mesh frame is the one frame that every
// process shares, and a torque is moved to another point exactly with Shift.)
struct Pointshell {
  std::vector<glm::dvec3> points_m;
  std::vector<glm::dvec3> inward_normals;
};

constexpr std::uint32_t kMaxPoints = 4'000'000;  // not derived; bounds memory and time

// Exactly `num_points` points: area-uniform candidates, four for each point wanted, are thinned by weighted sample
// elimination (Yuksel 2015), which leaves blue noise: the most crowded candidate is taken away until the number is
// right. Candidates whose normals are more than 120 degrees apart do not crowd each other, so thin walls keep both
// sides.
// Deterministic, with any number of workers. Errors: no area, too many points.
core::Result<Pointshell> BuildPointshell(const TriangleMesh& mesh, std::uint32_t num_points,
                                         const std::function<void(std::string_view, double)>& progress = {},
                                         core::ParallelFor* workers = nullptr);

}  // namespace vps
