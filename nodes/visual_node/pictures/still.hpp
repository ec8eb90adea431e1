#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/draw/composer.hpp"
#include "nodes/visual_node/options.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// Renders the scenario's initial state from each named camera to OUT/<camera>.png, without bus or window.
core::Result<void> RenderStills(const Options& options, const scene::Scenario& scenario);

// Renders a picture with kSmoothSamples in each direction of a pixel (supersampling).
core::Result<Image> RenderSmooth(Renderer& renderer, const view::Scene& scene, const scene::Camera& camera, int width,
                                 int height);

}  // namespace visual_node
