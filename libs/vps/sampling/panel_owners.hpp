#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/sampling/surface_panels.hpp"

namespace vps {

// Points about one spacing apart, with outward unit normals. Mesh frame, metres.
struct Places {
  std::vector<glm::dvec3> points_m, normals;
  double spacing_m = 0.0;
};

constexpr std::uint32_t kNobody = 0xffffffffU;

// For each panel the point that it belongs to, so that the faces of an edge keep their own area: the nearest one of its
// face; where there is none near, the nearest of all; kNobody where no point is near. Of the panel's face are points
// whose normal is within 45 degrees of its own, the nearer the less they lie off its plane:
//
//   |r|^2 + (4 n . r)^2 least,   r: from the panel to the point.
//
// A cell that joined parallel faces of different height would have its centroid between them, where there is no
// surface.
std::vector<std::uint32_t> FindOwners(const std::vector<SurfacePanel>& panels, const Places& places,
                                      core::ParallelFor* workers);

}  // namespace vps
