#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/options.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// Renders the scenario's initial state from each named camera to OUT/<camera>.png, without bus or window.
core::Result<void> RenderStills(const Options& options, const scene::Scenario& scenario);

// Renders a picture with 2 x 2 samples per pixel (supersampling).
constexpr int kSmoothSamples = 2;
core::Result<Image> RenderSmooth(Renderer& renderer, const view::Scene& scene, const scene::Camera& camera, int width,
                                 int height);

}  // namespace visual_node
