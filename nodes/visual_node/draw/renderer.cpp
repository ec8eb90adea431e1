#include "nodes/visual_node/draw/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "core/names.hpp"
#include "nodes/visual_node/draw/shaders.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "nodes/visual_node/gl/matrix.hpp"
#include "view/appearance/sheet_mesh.hpp"
#include "view/appearance/skin.hpp"
#include "view/projection.hpp"

namespace visual_node {
namespace {

// The shadow map is fitted anew when the sun has moved by a tenth of its width (cos 0.05 degrees): 75 minutes.
constexpr double kSameSun = 1.0 - 3.8e-7;

// Its mesh is drawn over surfaces, too.
bool IsOverlaid(const view::Scene& scene, std::size_t instance) {
  const view::Instance& its = scene.instances[instance];
  return its.highlight > 0.0f || its.opacity < 1.0f ||
         std::any_of(scene.phantoms.begin(), scene.phantoms.end(),
                     [instance](const view::Phantom& phantom) { return phantom.instance == instance; });
}

void SetMatrix(GLint location, const glm::mat4& matrix) {
  glUniformMatrix4fv(location, 1, GL_FALSE, glm::value_ptr(matrix));
}

}  // namespace

core::Result<std::unique_ptr<Renderer>> Renderer::Create(const view::Scene& scene, const Ingredients& ingredients) {
  if (!ingredients.meshes) return tl::unexpected(ingredients.meshes.error());
  if (!ingredients.sky) return tl::unexpected(ingredients.sky.error());
  std::unique_ptr<Renderer> renderer(new Renderer);
  if (auto made = renderer->MakeMeshes(scene, *ingredients.meshes); !made) return tl::unexpected(made.error());
  if (auto made = renderer->MakePainters(ingredients); !made) return tl::unexpected(made.error());
  renderer->nothing_ = MakeVertexArray();
  renderer->picked_ = PickedTriangles::Create();
  renderer->details_.resize(renderer->meshes_.size());
  renderer->FitShadow(scene);
  return renderer;
}

core::Result<void> Renderer::MakeMeshes(const view::Scene& scene, const std::vector<MeshData>& meshes) {
  for (const MeshData& data : meshes) {
    const bool has_skin = !data.mesh.joints.empty();
    meshes_.push_back(Upload(data, has_skin));
    if (has_skin) skins_.push_back({meshes_.size() - 1, data.mesh, data.mesh, nullptr});
  }
  if (auto taken = TakeLooks(scene); !taken) return taken;
  for (const view::Sheet& sheet : scene.sheets) {
    sheets_.push_back(Upload(vps::VisualMesh{{view::MakeSheetMesh(sheet)}}, true));
    sheet_versions_.push_back(sheet.version);
    num_triangles_ += static_cast<std::size_t>(sheets_.back().num_indices) / 3;
  }
  for (const view::Instance& instance : scene.instances) {
    num_triangles_ += static_cast<std::size_t>(meshes_[instance.mesh].num_indices) / 3;
  }
  return {};
}

core::Result<void> Renderer::MakePainters(const Ingredients& ingredients) {
  const auto put = [](auto made, auto* into) -> core::Result<void> {
    if (!made) return tl::unexpected(made.error());
    *into = std::move(*made);
    return {};
  };
  if (auto made = put(MakeProgram("glow", kGlowVertex, kGlowFragment), &glow_); !made) return made;
  if (auto made = put(SurfacePainter::Create(ingredients.surfaces), &surfaces_); !made) return made;
  for (const GpuMesh& mesh : meshes_) {
    if (auto prepared = surfaces_.Prepare(mesh); !prepared) return prepared;
  }
  if (auto made = put(Film::Create(IsSoftwareRenderer(RendererName())), &film_); !made) return made;
  if (auto made = put(ShadowMap::Create(), &shadow_); !made) return made;
  if (auto made = put(Sky::Create(*ingredients.sky), &sky_); !made) return made;
  if (auto made = put(TextPainter::Create(), &texts_); !made) return made;
  if (auto made = put(PastePainter::Create(), &paste_); !made) return made;
  return put(OverlayPainter::Create(), &overlays_);
}

// Which variant each instance shows, and whether each skin has its joints.
core::Result<void> Renderer::TakeLooks(const view::Scene& scene) {
  const view::Assets& assets = *scene.assets;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const std::string name = i < assets.variants.size() ? assets.variants[i] : std::string();
    const std::vector<std::string>& known = meshes_[scene.instances[i].mesh].variants;
    const auto found = std::find(known.begin(), known.end(), name);
    variants_.push_back(found == known.end() ? -1 : static_cast<int>(found - known.begin()));
    if (found == known.end() && !name.empty()) {
      return core::Fail(core::ErrorCode::kInvalidInput, assets.meshes[scene.instances[i].mesh].string() +
                                                            ": it has no variant '" + name + "'; " +
                                                            core::SuggestName(name, known));
    }
  }
  for (const Skin& skin : skins_) {
    for (const view::Instance& instance : scene.instances) {
      if (instance.mesh != skin.mesh || instance.posture == nullptr) continue;
      if (instance.posture->size() == skin.source.joints.size()) continue;
      return core::Fail(core::ErrorCode::kInvalidInput, assets.meshes[skin.mesh].string() + ": its skin has " +
                                                            std::to_string(skin.source.joints.size()) +
                                                            " joints, and the scenario names " +
                                                            std::to_string(instance.posture->size()));
    }
  }
  return {};
}

// Fits the shadow map to the sphere around the bounding box of all objects, 10 % larger so that they can move. What is
// scenery casts shadows into it, but would make it coarse.
void Renderer::FitShadow(const view::Scene& scene) {
  glm::dvec3 low(1e9), high(-1e9);
  for (const view::Instance& instance : scene.instances) {
    const GpuMesh& mesh = meshes_[instance.mesh];
    if (!instance.is_visible || instance.is_scenery || mesh.num_indices == 0) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 side((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      const glm::dvec3 p_W = instance.X_WM * glm::dvec3(mesh.centre_M + side * mesh.half_size_m);
      low = glm::min(low, p_W);
      high = glm::max(high, p_W);
    }
  }
  if (low.x > high.x) low = high = glm::dvec3(0.0);
  const double radius_m = std::max(0.05, 0.5 * 1.10 * glm::length(high - low));
  shadow_sun_W_ = scene.space.sun_direction_W;
  shadow_.Fit(scene.space.sun_direction_W, 0.5 * (low + high), radius_m);
}

void Renderer::UpdateSkins(const view::Scene& scene, bool has_surfaces) {
  for (Skin& skin : skins_) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      const view::Instance& instance = scene.instances[i];
      if (instance.mesh != skin.mesh || instance.posture == nullptr || instance.posture == skin.shown) continue;
      if (has_surfaces && !IsOverlaid(scene, i)) continue;
      skin.shown = instance.posture;
      view::BendSkin(skin.source, *skin.shown, &skin.posed);
      UpdateVertices(skin.posed, &meshes_[skin.mesh]);
    }
  }
}

void Renderer::UpdateSheets(const view::Scene& scene) {
  for (std::size_t i = 0; i < sheets_.size() && i < scene.sheets.size(); ++i) {
    if (sheet_versions_[i] == scene.sheets[i].version) continue;
    sheet_versions_[i] = scene.sheets[i].version;
    UpdateVertices({{view::MakeSheetMesh(scene.sheets[i])}}, &sheets_[i]);
  }
}

void Renderer::SetDetail(std::size_t mesh, const vps::VisualMesh& vertices, const std::vector<Piece>& pieces) {
  // A skin's vertices are others with every posture.
  if (std::any_of(skins_.begin(), skins_.end(), [mesh](const Skin& skin) { return skin.mesh == mesh; })) return;
  DetailedMesh& detail = details_[mesh];
  detail.levels = MeshDetail(vertices, pieces);
  detail.vertices = UploadVertices(vertices);
  detail.layout = MakeLayout(detail.vertices, detail.vertices, picked_.buffer());
}

core::Result<void> Renderer::Draw(const view::Scene& scene, const scene::Camera& given, const RenderTarget& target,
                                  const Look& look) {
  const double aspect = static_cast<double>(target.width()) / target.height();
  return Draw(scene, view::FrustumOf(view::PlaceCamera(given, scene), aspect), target, look);
}

core::Result<void> Renderer::Draw(const view::Scene& scene, const view::Frustum& eye, const RenderTarget& target,
                                  const Look& look) {
  UpdateSkins(scene, !look.surfaces.empty());
  if (look.surfaces.empty()) {
    if (glm::dot(scene.space.sun_direction_W, shadow_sun_W_) < kSameSun) FitShadow(scene);
    UpdateSheets(scene);
    const bool is_exact = look.detail_px <= 0.0;
    shadow_.Update(scene, meshes_, sheets_, is_exact ? ShadowMap::Coarse{} : ShadowMap::Coarse{&details_, &picked_});
  }
  const glm::dmat4 view_W = view::ViewMatrix(eye);
  const glm::dmat4 projection = view::ProjectionMatrix(eye, kNear_m, kFar_m);
  View view;
  view.clip_W = glm::mat4(projection * view_W);
  view.clip_sky = glm::mat4(projection * glm::dmat4(glm::dmat3(view_W)));
  view.eye_W = glm::vec3(eye.eye_W);
  view.right_W = glm::vec3(view_W[0][0], view_W[1][0], view_W[2][0]);
  view.up_W = glm::vec3(view_W[0][1], view_W[1][1], view_W[2][1]);
  view.exposure = look.exposure;

  const auto scaled = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(look.scale * pixels))); };
  const int width = look.surfaces.empty() ? scaled(target.width()) : look.surfaces.front().at.width;
  const int height = look.surfaces.empty() ? scaled(target.height()) : look.surfaces.front().at.height;
  const glm::dmat3 R_VC = glm::dmat3(view_W) * glm::mat3_cast(scene.space.R_WC);
  const glm::dvec2 focal_px = view::FocalLengths_px(eye, width, height);
  sky_.Prepare(scene.space,
               {R_VC, focal_px.x, width, height, focal_px.y / focal_px.x, view::AxisFromMiddle_px(eye, width, height)});

  // A pixel is one focal length's share of the distance along the view.
  view.allowed_share = static_cast<float>(look.detail_px / std::max(focal_px.x, focal_px.y));

  film_.Begin(width, height);
  if (!look.surfaces.empty()) {
    paste_.Draw(look.surfaces.front(), static_cast<float>(kNear_m), static_cast<float>(kFar_m));
  } else {
    DrawSolids(scene, view, eye, look);
  }
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_FALSE);
  sky_.Draw(scene.space, view.clip_sky);
  DrawGlow(scene, view);
  overlays_.Draw(scene, meshes_, {view.clip_W, view.eye_W, view.exposure, static_cast<float>(projection[1][1])}, film_);
  glDepthMask(GL_TRUE);
  film_.Develop(look.exposure, target);
  if (!look.with_texts) return {};
  return DrawTexts(HudOf(scene, eye, target.width(), target.height()), target.width(), target.height());
}

// What is opaque, onto the film, with its shadows.
void Renderer::DrawSolids(const view::Scene& scene, const View& view, const view::Frustum& eye, const Look& look) {
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  // At what the camera looks at, casters half the map's radius away have a penumbra of two pixels.
  const double pixel_m = eye.focus_m * (eye.top - eye.bottom) / film_.height();
  const bool has_soft_shadows = look.with_penumbra && view::kSunRadius_rad * shadow_.radius_m() > 2.0 * pixel_m;
  surfaces_.Begin(
      {view.clip_W, view.eye_W, has_soft_shadows, look.light ? *look.light : LightAround(scene), ShiningLamps(scene)},
      shadow_);
  DrawSurfaces(scene, view);
  DrawSheets(scene);
}

std::vector<SurfaceFrame::Lamp> Renderer::ShiningLamps(const view::Scene& scene) const {
  std::vector<SurfaceFrame::Lamp> lamps;
  for (const view::Lamp& lamp : scene.lamps) {
    const view::Instance& instance = scene.instances[lamp.instance];
    if (lamp.color == glm::vec3(0.0f) || !instance.is_visible) continue;
    const GpuMesh& mesh = meshes_[instance.mesh];
    lamps.push_back({glm::vec4(instance.X_WM * glm::dvec3(mesh.centre_M), 2.5f * mesh.radius_m), lamp.color});
  }
  return lamps;
}

// Nearest instances first, so that the depth test rejects hidden fragments before they are shaded.
void Renderer::DrawSurfaces(const view::Scene& scene, const View& view) {
  order_.clear();
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    const GpuMesh& mesh = meshes_[instance.mesh];
    if (!instance.is_visible || instance.opacity < 1.0f || mesh.num_indices == 0) continue;
    const glm::vec3 centre_W(instance.X_WM * glm::dvec3(mesh.centre_M));
    if (IsOutside(view.clip_W, centre_W, mesh.radius_m)) continue;
    order_.emplace_back(glm::distance(centre_W, view.eye_W) - mesh.radius_m, i);
  }
  std::sort(order_.begin(), order_.end());
  PickTriangles(scene, view);
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const view::Instance& instance = scene.instances[order_[place].second];
    const GpuMesh& mesh = meshes_[instance.mesh];
    const glm::mat4 X_WM = ToMatrix(instance.X_WM);
    for (std::size_t k = 0; k < mesh.parts.size(); ++k) {
      const GpuMesh::Part& part = mesh.parts[k];
      const GpuMesh::Look& look = part.look(variants_[order_[place].second]);
      // Of a lamp with a lens only the lens shines.
      const bool is_given = instance.is_material_given && (!mesh.has_lens || look.is_lens);
      view::Material material = is_given ? instance.material : look.material;
      if (!instance.is_material_given) material.emissive += instance.material.emissive;
      if (picked_runs_[place].empty()) {
        surfaces_.Draw(mesh, part, look, X_WM, material, !is_given);
      } else {
        surfaces_.Draw(mesh, look, X_WM, material, !is_given, details_[instance.mesh].layout.id(),
                       picked_runs_[place][k]);
      }
    }
  }
}

void Renderer::PickTriangles(const view::Scene& scene, const View& view) {
  picked_runs_.assign(order_.size(), {});
  if (view.allowed_share <= 0.0f) return;
  picked_.Clear();
  for (std::size_t place = 0; place < order_.size(); ++place) {
    const view::Instance& instance = scene.instances[order_[place].second];
    const MeshDetail& levels = details_[instance.mesh].levels;
    if (levels.is_empty()) continue;
    picked_runs_[place] = picked_.Add(levels, {view.clip_W * ToMatrix(instance.X_WM), 0.0f, view.allowed_share});
  }
  picked_.Upload();
}

void Renderer::DrawSheets(const view::Scene& scene) {
  for (std::size_t i = 0; i < sheets_.size() && i < scene.sheets.size(); ++i) {
    if (!scene.sheets[i].is_visible) continue;
    for (const GpuMesh::Part& part : sheets_[i].parts) {
      surfaces_.Draw(sheets_[i], part, part, glm::mat4(1.0f), scene.sheets[i].material);
    }
  }
}

void Renderer::DrawGlow(const view::Scene& scene, const View& view) const {
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glUseProgram(glow_.id());
  glBindVertexArray(nothing_.id());
  SetMatrix(0, view.clip_W);
  for (const view::Lamp& lamp : scene.lamps) {
    const view::Instance& instance = scene.instances[lamp.instance];
    if (!instance.is_visible) continue;
    const GpuMesh& mesh = meshes_[instance.mesh];
    const glm::vec3 centre_W(instance.X_WM * glm::dvec3(mesh.centre_M));
    // The quad is in front of the lamp, so that only other objects hide it.
    const glm::vec3 quad_W = centre_W + 1.2f * mesh.radius_m * glm::normalize(view.eye_W - centre_W);
    const float reach_m = 3.2f * mesh.radius_m;
    glUniform3fv(1, 1, glm::value_ptr(quad_W));
    glUniform3fv(2, 1, glm::value_ptr(reach_m * view.right_W));
    glUniform3fv(3, 1, glm::value_ptr(reach_m * view.up_W));
    glUniform3fv(4, 1, glm::value_ptr(lamp.color));
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
  glDisable(GL_BLEND);
}

}  // namespace visual_node
