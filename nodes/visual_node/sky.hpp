#pragma once

#include <glm/glm.hpp>

#include "core/result.hpp"
#include "nodes/visual_node/gl_objects.hpp"

namespace visual_node {

// The background: black space, stars, and the Earth with its atmosphere. The Earth is computed once, at the start, into
// a cube map, which a frame samples where nothing else is drawn. The stars have a fixed seed, so pictures are
// reproducible.
class Sky {
 public:
  static core::Result<Sky> Create(const glm::dvec3& sun_direction_W);

  // Call it after the surfaces: fills the pixels at the far plane. `clip_sky` is the clip matrix without the
  // translation of the eye.
  void Draw(const glm::mat4& clip_sky, int target_height) const;

 private:
  core::Result<void> Bake(const glm::dvec3& sun_direction_W);
  void MakeStars();

  GlProgram background_;
  GlProgram star_;
  GlTexture cube_;
  GlVertexArray nothing_;  // the core profile requires one, even when the shader generates its vertices
  GlVertexArray star_layout_;
  GlBuffer star_vertices_;
  int num_stars_ = 0;
};

}  // namespace visual_node
