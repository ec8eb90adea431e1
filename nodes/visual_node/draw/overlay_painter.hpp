#pragma once

#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/film/film.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"
#include "view/scene.hpp"

namespace visual_node {

// Draws what explains a scene onto the film: arrows, rings, axes, lines and points, faint where parts hide them, and
// phantoms. Labels and texts are TextPainter's.
class OverlayPainter {
 public:
  struct View {
    glm::mat4 clip_W{1.0f};
    glm::vec3 eye_W{0.0f};
    float exposure = 1.0f;
    float clip_per_up = 1.0f;  // clip units per metre across the view at the distance 1: cot(vertical fov / 2)
  };

  static core::Result<OverlayPainter> Create();

  // After the surfaces and the sky. Depth is neither cleared nor written.
  void Draw(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const View& view, const Film& film);

 private:
  void DrawPhantoms(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const View& view, const Film& film);
  void DrawBodies(const view::Scene& scene, const View& view, bool is_solid) const;
  void DrawArrow(const view::Arrow& arrow, const View& view, float opacity) const;
  void DrawRing(const view::RingArrow& ring, const View& view, float opacity) const;
  void DrawLine(const view::LineStrip& line, const View& view, const Film& film, float opacity);
  void DrawPoints(const view::PointSet& set, const View& view, const Film& film, float opacity);
  void DrawCubes(const view::Cubes& cubes, const View& view);
  void DrawSpheres(const view::Spheres& spheres, const View& view);
  void UseGrains(const GlProgram& program, const core::Pose& X_WP, const View& view, const glm::vec4& color) const;
  void DrawGrains(const void* grains, std::size_t count, std::size_t stride_bytes);
  void Reserve(std::size_t num_points);
  void UseBodies(const GlProgram& program, const View& view) const;

  GpuMesh shaft_;
  GpuMesh head_;
  GpuMesh tube_;  // of a ring
  GlProgram body_;
  GlProgram ring_;
  GlProgram line_;
  GlProgram point_;
  GlProgram cube_;
  GlProgram sphere_;
  GlProgram phantom_;
  GlProgram mix_;
  GlVertexArray nothing_;
  GlVertexArray strip_layout_;
  GlVertexArray set_layout_;
  GlVertexArray grain_layout_;  // an instance each
  GlBuffer strip_points_;
  GlBuffer strip_colors_;
  std::size_t capacity_points_ = 0;
  GlTexture sum_;
  GlTexture seen_;
  GlFramebuffer framebuffer_;
  int width_ = 0, height_ = 0;
};

}  // namespace visual_node
