#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace oos {

// A scenario as JSON, for viewers in other languages: objects in the order of their indices on the bus (mesh, colour,
// initial pose, and the hand that they are part of), meshes as parts of one colour (positions [m], and three indices
// for each triangle), hands, cameras, and the procedure's steps in order. A pose is [w, x, y, z, px, py, pz]. Colours
// are linear. Fails if a mesh cannot be read.
core::Result<nlohmann::json> SceneJson(const scene::Scenario& scenario);

}  // namespace oos
