#pragma once

#include "core/result.hpp"
#include "proto/web_scene.pb.h"
#include "scene/scenario.hpp"
#include "space/atmosphere/from_space.hpp"
#include "view/scene.hpp"

namespace scene_stream {

// What the page gets once: meshes, materials, tables, stars, and the shaders of the OpenGL renderer, so that both draw
// the same. Error: a mesh that cannot be read.
core::Result<oos::SceneAssets> MakeAssets(const scene::Scenario& scenario, const view::Scene& scene,
                                          const space::AirFromSpace& air);

}  // namespace scene_stream
