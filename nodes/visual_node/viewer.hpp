#pragma once

#include <csignal>
#include <cstdint>
#include <string>

#include "core/result.hpp"
#include "nodes/visual_node/options.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// Set by signal handlers; read by the viewer between frames.
struct Signals {
  volatile std::sig_atomic_t is_stop_wanted = 0;
  volatile std::sig_atomic_t is_screenshot_wanted = 0;
};

// Shows the scenario live until it is told to stop or its window is closed. Leaves in OUT: frames/<step>.png and
// contact_sheet.png (each step as it looked when it ended), pictures asked for, latency_visual.csv, visual_node.json.
core::Result<void> RunViewer(const Options& options, const scene::Scenario& scenario, Signals& signals);

}  // namespace visual_node
