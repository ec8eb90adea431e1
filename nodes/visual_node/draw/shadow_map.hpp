#pragma once

#include <vector>

#include "nodes/visual_node/draw/detail_picker.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"
#include "view/scene.hpp"

namespace visual_node {

// Shadow map: depth of the scene as seen from the sun. Fixed objects are drawn once; movable ones are drawn over a
// copy, and only after something has moved. On a software renderer this saves most of a frame's vertices.
class ShadowMap {
 public:
  static constexpr int kSize = 1024;  // texels per side; chosen by eye: larger is sharper and slower to copy

  static core::Result<ShadowMap> Create();

  // Fits the map to the sphere (centre, radius) and discards its content. Call it again when the sun or the meshes
  // change.
  void Fit(const glm::dvec3& sun_direction_W, const glm::dvec3& centre_W, double radius_m);
  // For live pictures: casters may be half a texel off their place, and are drawn with as little detail as that allows.
  struct Coarse {
    const std::vector<DetailedMesh>* details = nullptr;  // index: Assets::meshes; none: exact
    PickedTriangles* picked = nullptr;                   // to be filled anew
  };
  // Draws what has moved since the last update. `sheets`: one mesh per sheet of the scene, in W.
  void Update(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const std::vector<GpuMesh>& sheets,
              const Coarse& coarse);

  [[nodiscard]] GLuint texture() const { return depth_.id(); }
  [[nodiscard]] const glm::mat4& sun_W() const { return sun_W_; }
  [[nodiscard]] float texel_m() const { return texel_m_; }
  [[nodiscard]] double radius_m() const { return 0.5 * kSize * texel_m_; }
  [[nodiscard]] int num_updates() const { return num_updates_; }

 private:
  [[nodiscard]] static std::uint64_t VersionOfSheets(const view::Scene& scene);
  [[nodiscard]] static std::vector<bool> CastersOf(const view::Scene& scene);
  bool HasMoved(const view::Scene& scene, const std::vector<GpuMesh>& meshes, double slack_m) const;
  bool HaveSheetsMoved(const view::Scene& scene, double slack_m) const;
  void DrawCasters(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const Coarse& coarse,
                   bool is_movable) const;

  GlProgram program_;
  GlTexture depth_;
  GlTexture static_depth_;
  GlFramebuffer framebuffer_;
  GlFramebuffer static_framebuffer_;
  glm::mat4 sun_W_{1.0f};
  float texel_m_ = 0.0f;
  bool is_static_drawn_ = false;
  bool is_static_exact_ = false, is_exact_ = false;
  int num_updates_ = 0;
  std::vector<core::Pose> drawn_;  // poses of the last update
  std::vector<view::Posture> drawn_postures_;
  std::vector<bool> casters_;                        // which instances cast a shadow
  std::uint64_t drawn_sheets_ = 0;                   // sum of the sheets' versions
  std::vector<std::vector<glm::vec3>> drawn_nodes_;  // of the sheets
};

}  // namespace visual_node
