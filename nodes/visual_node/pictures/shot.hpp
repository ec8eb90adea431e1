#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/options.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// The files that `options` names, of this scene.
core::Result<void> TakeShot(const Options& options, const view::Scene& scene, Renderer* renderer);

// The scene that these options show. Errors: kIo, kDamaged, kNotFound; kInvalidInput for a time beyond the recording.
core::Result<view::Scene> SceneOf(const Options& options, const scene::Scenario& scenario);

// One picture of it, and what is measured in it: the files that `options` names. Errors: kInvalidInput for an
// unknown camera or a time beyond the recording, kIo.
core::Result<void> RenderShot(const Options& options, const scene::Scenario& scenario);

}  // namespace visual_node
