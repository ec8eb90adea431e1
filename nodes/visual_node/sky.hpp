#pragma once

#include <glm/glm.hpp>

#include "core/result.hpp"
#include "nodes/visual_node/gl_objects.hpp"

namespace visual_node {

// What is behind the scene: black space, a few stars, the Earth with its thin air. The Earth is computed once, at the
// start, into a cube map; a frame only looks it up where nothing else is. The same picture everywhere: no random
// source.
class Sky {
 public:
  static core::Result<Sky> Create(const glm::dvec3& sun_direction_W);

  // After the surfaces: fills what is still at the far plane. `clip_sky` is the clip matrix without the eye's position.
  void Draw(const glm::mat4& clip_sky, int target_height) const;

 private:
  core::Result<void> Bake(const glm::dvec3& sun_direction_W);
  void MakeStars();

  GlProgram background_;
  GlProgram star_;
  GlTexture cube_;
  GlVertexArray nothing_;  // core profile wants one bound, also when a shader makes its own vertices
  GlVertexArray star_layout_;
  GlBuffer star_vertices_;
  int num_stars_ = 0;
};

}  // namespace visual_node
