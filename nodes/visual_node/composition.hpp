#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/draw/composer.hpp"
#include "nodes/visual_node/options.hpp"

namespace visual_node {

// As the command line wants it. Error: kInvalidInput, when the layout has an unknown camera.
inline core::Result<Composition> CompositionOf(const Options& options, const view::Assets& assets) {
  Composition composition;
  composition.layout.rows = {{options.view}};
  if (!options.layout.empty()) {
    auto layout = view::ReadLayout(options.layout, assets);
    if (!layout) return tl::unexpected(layout.error());
    composition.layout = std::move(*layout);
  }
  composition.viewing.stereo = options.stereo;
  composition.viewing.eye_distance_m = options.eye_distance_m;
  composition.viewing.screen_R = options.screen_R;
  return composition;
}

}  // namespace visual_node
