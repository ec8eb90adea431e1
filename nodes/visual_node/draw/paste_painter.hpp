#pragma once

#include "core/result.hpp"
#include "nodes/visual_node/draw/pasted.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"

namespace visual_node {

// Puts surfaces that were drawn elsewhere onto the film: their light, and their depths, by which the sky and what
// explains the scene are added. The film has the size of their part of the canvas.
class PastePainter {
 public:
  // Error: kUnsupported, when the driver cannot compile the shader.
  static core::Result<PastePainter> Create();

  void Draw(const Pasted& surfaces, float near_m, float far_m);

 private:
  GlProgram program_;
  GlVertexArray nothing_;  // the core profile requires one, even when the shader generates its vertices
  GlTexture light_;
  GlTexture depth_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace visual_node
