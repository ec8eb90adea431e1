#pragma once

#include <vector>

#include "core/result.hpp"
#include "physics/mass_properties.hpp"
#include "scene/scenario.hpp"

namespace collision {

// Mass properties of every physics-owned object: as given, or from its mesh with the given density or scaled to the
// given mass. An open mesh (a sheet) with a given mass gets the inertia of its bounding box.
core::Result<std::vector<physics::MassProperties>> LoadMasses(const scene::Scenario& scenario);

}  // namespace collision
