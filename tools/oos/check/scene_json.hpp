#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace oos {

// What a viewer in another language needs of a scenario: objects in the order of their indices on the bus (mesh,
// colour, pose at the start, part of which hand), meshes as parts of one colour (positions [m] and indices, three for a
// triangle), hands, cameras, and the procedure's steps in order. A pose is [w, x, y, z, px, py, pz]. Colours are
// linear. Fails when a mesh cannot be read.
core::Result<nlohmann::json> SceneJson(const scene::Scenario& scenario);

}  // namespace oos
