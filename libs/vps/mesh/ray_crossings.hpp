#pragma once

#include <array>
#include <optional>
#include <vector>

#include "vps/mesh/box_tree.hpp"

namespace vps {

// The winding number of a closed, consistently oriented surface around p: how often a ray from p leaves through it less
// how often it enters. The surface may cross itself. `triangles` in the tree's order. None where rounding leaves a
// crossing in doubt for each of a few directions: p is as good as on the surface.
std::optional<int> CountRayCrossings(const BoxTree& tree, const std::vector<std::array<glm::dvec3, 3>>& triangles,
                                     const glm::dvec3& p);

}  // namespace vps
