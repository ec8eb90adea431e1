#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/sampling/surface_panels.hpp"

namespace vps {

// Points whose spacing varies, with outward normals. Mesh frame, metres.
struct Places {
  std::vector<glm::dvec3> points_m, normals;
  std::vector<double> spacings_m;
};

constexpr std::uint32_t kNobody = 0xffffffffU;

// For each panel the point that it belongs to: the nearest whose normal is within 45 degrees of its own, so that the
// faces of an edge keep their own area; where there is none near, the nearest of all; kNobody where no point is near.
std::vector<std::uint32_t> FindOwners(const std::vector<SurfacePanel>& panels, const Places& places,
                                      core::ParallelFor* workers);

}  // namespace vps
