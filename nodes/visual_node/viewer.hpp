#pragma once

#include <csignal>
#include <cstdint>
#include <string>

#include "core/result.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/surfaces.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// Set by signal handlers; read by the viewer between frames.
struct Signals {
  volatile std::sig_atomic_t is_stop_wanted = 0;
  volatile std::sig_atomic_t is_screenshot_wanted = 0;
};

// Shows the scenario live until a stop signal or the closing of its window. Writes to OUT: frames/<step>.png and
// contact_sheet.png (each step at its end), requested pictures, latency_visual.csv and visual_node.json. `surfaces`:
// who draws what is opaque of the live pictures; null: the viewer itself.
core::Result<void> RunViewer(const Options& options, const scene::Scenario& scenario, Signals& signals,
                             Surfaces* surfaces = nullptr);

}  // namespace visual_node
