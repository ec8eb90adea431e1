#pragma once

#include <memory>
#include <string>

#include "core/result.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "scene/scenario.hpp"

namespace visual_node {

// A renderer without window and bus.
struct Offline {
  std::unique_ptr<GlContext> context;
  std::unique_ptr<Renderer> renderer;  // deleted before its context

  // Fitted to the scenario as it begins, as the live viewer is, whatever is drawn then. Errors: no display, no OpenGL
  // 4.5, a mesh that cannot be read; kInvalidInput: `camera` is neither empty nor one of the scenario's.
  static core::Result<Offline> Create(const scene::Scenario& scenario, const std::string& camera);
};

}  // namespace visual_node
