#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/draw/detail_picker.hpp"
#include "nodes/visual_node/draw/ingredients.hpp"
#include "nodes/visual_node/draw/overlay_painter.hpp"
#include "nodes/visual_node/draw/paste_painter.hpp"
#include "nodes/visual_node/draw/shadow_map.hpp"
#include "nodes/visual_node/draw/surface_painter.hpp"
#include "nodes/visual_node/draw/text_painter.hpp"
#include "nodes/visual_node/film/exposure.hpp"
#include "nodes/visual_node/film/film.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"
#include "nodes/visual_node/sky/sky.hpp"
#include "view/frustum.hpp"
#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// How a picture is taken. Those that are to be compared have the defaults.
struct Look {
  float exposure = Exposure::kDaylight;
  double scale = 1.0;  // of the film's width and height, against the target's
  bool with_texts = true;
  bool with_penumbra = true;  // as dear as all other shading on a software renderer; live pictures leave it out
  // How far a surface may be off its place, in pixels of the film; 0: all that there is of each mesh is drawn.
  double detail_px = 0.0;
  std::optional<view::EnvironmentLight> light = std::nullopt;  // none: that of the scene's surroundings
  // Already drawn by somebody else, for each view of the picture; the film has their size then. Empty: by OpenGL.
  std::span<const Pasted> surfaces = {};
};

// Draws a view::Scene with OpenGL 4.5 core. All calls come from one thread, on which the context is current.
class Renderer {
 public:
  // Clip planes: a hand's width in front of the eye, and far beyond any scenario. A ratio of 6000 leaves a 24-bit depth
  // buffer a resolution of d^2 / (2^24 near): 6 um at 1 m.
  static constexpr double kNear_m = 0.01;
  static constexpr double kFar_m = 60.0;

  // The ingredients are of the scene's assets. Errors name the file, or the shader that does not compile.
  static core::Result<std::unique_ptr<Renderer>> Create(const view::Scene& scene, const Ingredients& ingredients);
  static core::Result<std::unique_ptr<Renderer>> Create(const view::Scene& scene, const MeshLoader& load_mesh) {
    return Create(scene, MakeIngredients(scene.assets->meshes, load_mesh));
  }

  // Draws one picture; a camera that is carried stands where its object is.
  core::Result<void> Draw(const view::Scene& scene, const scene::Camera& given, const RenderTarget& target,
                          const Look& look = {});
  // What an eye sees.
  core::Result<void> Draw(const view::Scene& scene, const view::Frustum& eye, const RenderTarget& target,
                          const Look& look = {});
  // Text alone, into the bound framebuffer's viewport: laid out for so many pixels, whatever its size is.
  core::Result<void> DrawTexts(const Hud& hud, int width, int height) { return texts_->Draw(hud, width, height); }

  // What these lines will cover of it.
  core::Result<std::vector<Box>> TextBlocks(const std::vector<view::TextLine>& lines, int width, int height) {
    return texts_->BlocksOf(lines, width, height);
  }

  // Without it the Earth has no air.
  void SetAir(const space::AirFromSpace& air) { sky_.SetAir(air); }
  // Of a scene's surroundings.
  [[nodiscard]] view::EnvironmentLight LightAround(const view::Scene& scene) const {
    return view::LightOf(scene.space, sky_.air());
  }

  // What Look::detail_px chooses from. Until then meshes are drawn whole. Index: Assets::meshes.
  void SetDetail(std::size_t mesh, const vps::VisualMesh& vertices, const std::vector<Piece>& pieces);

  // Of the newest picture, and waits for it.
  [[nodiscard]] Film& film() { return film_; }
  // As they were drawn last. Index: Assets::meshes, Scene::sheets.
  [[nodiscard]] const std::vector<GpuMesh>& meshes() const { return meshes_; }
  [[nodiscard]] const std::vector<GpuMesh>& sheets() const { return sheets_; }

  [[nodiscard]] const std::vector<PlacedLine>& placed_lines() const { return texts_->placed(); }
  [[nodiscard]] const std::string& sky_note() const { return sky_.note(); }
  [[nodiscard]] std::size_t num_triangles() const { return num_triangles_; }
  [[nodiscard]] float shadow_texel_m() const { return shadow_.texel_m(); }
  [[nodiscard]] int num_shadow_updates() const { return shadow_.num_updates(); }

 private:
  struct View {  // one camera and target, ready for the shaders
    glm::mat4 clip_W;
    glm::mat4 clip_sky;
    glm::vec3 eye_W;
    glm::vec3 right_W;
    glm::vec3 up_W;
    float exposure = 1.0f;
    float allowed_share = 0.0f;  // of the distance along the view, by which a surface may be off its place
  };

  Renderer() = default;
  core::Result<void> MakeMeshes(const view::Scene& scene, const std::vector<MeshData>& meshes);
  core::Result<void> MakePainters(const Ingredients& ingredients);
  void FitShadow(const view::Scene& scene);
  void DrawSolids(const view::Scene& scene, const View& view, const view::Frustum& eye, const Look& look);
  core::Result<void> TakeLooks(const view::Scene& scene);
  void UpdateSheets(const view::Scene& scene);
  // `has_surfaces`: somebody else has drawn them.
  void UpdateSkins(const view::Scene& scene, bool has_surfaces);
  void DrawSurfaces(const view::Scene& scene, const View& view);
  void PickTriangles(const view::Scene& scene, const View& view);
  void DrawSheets(const view::Scene& scene);
  void DrawGlow(const view::Scene& scene, const View& view) const;
  [[nodiscard]] std::vector<SurfaceFrame::Lamp> ShiningLamps(const view::Scene& scene) const;

  struct Skin {
    std::size_t mesh = 0;  // index into meshes_
    vps::VisualMesh source;
    vps::VisualMesh posed;
    view::Posture shown;
  };

  std::vector<GpuMesh> meshes_;  // index: Assets::meshes
  std::vector<Skin> skins_;
  std::vector<int> variants_;          // of each instance, of its mesh; -1: the first look
  std::vector<DetailedMesh> details_;  // the same; empty levels: none
  std::vector<GpuMesh> sheets_;        // index: Scene::sheets
  std::vector<std::uint64_t> sheet_versions_;
  SurfacePainter surfaces_;
  OverlayPainter overlays_;
  PastePainter paste_;
  GlProgram glow_;
  GlVertexArray nothing_;  // the core profile requires one, even when the shader generates its vertices
  Film film_;
  ShadowMap shadow_;
  Sky sky_;
  glm::dvec3 shadow_sun_W_{0.0};
  std::unique_ptr<TextPainter> texts_;
  std::size_t num_triangles_ = 0;
  std::vector<std::pair<float, std::size_t>> order_;  // instances, nearest first
  PickedTriangles picked_;
  std::vector<std::vector<PickedTriangles::Run>> picked_runs_;  // in this order; empty: the whole mesh
};

}  // namespace visual_node
