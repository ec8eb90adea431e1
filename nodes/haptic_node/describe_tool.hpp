#pragma once

#include <cstddef>

#include "scene/scenario.hpp"
#include "vps/coupling/tool_metric.hpp"

namespace haptic_node {

// The rigid tool that a hand's parts make, at its opening of the start. Parts fill their collision meshes. A hand of
// which no part has a mass or a density is a tool without mass; its centre of mass is that of the volumes.
// `radius_m`: of all points of the hand about its origin; 0: not known.
vps::GodObjectParameters DescribeTool(const scene::Scenario& scenario, std::size_t role, double radius_m);

}  // namespace haptic_node
