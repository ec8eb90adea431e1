#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/renderer.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// The scenario as it starts, once from each named camera, to OUT/<camera>.png. No bus, no window.
core::Result<void> RenderStills(const Options& options, const scene::Scenario& scenario);

// A picture smoothed from 2 x 2 samples per pixel.
core::Result<Image> RenderSmooth(Renderer& renderer, const view::Scene& scene, const scene::Camera& camera, int width,
                                 int height);

}  // namespace visual_node
