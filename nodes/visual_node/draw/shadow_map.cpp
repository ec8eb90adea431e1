#include "nodes/visual_node/draw/shadow_map.hpp"

#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

#include "nodes/visual_node/draw/shaders.hpp"
#include "nodes/visual_node/gl/matrix.hpp"
#include "view/projection.hpp"

namespace visual_node {
namespace {

GlTexture MakeDepthTexture() {
  GlTexture texture = MakeTexture(GL_DEPTH_COMPONENT24, ShadowMap::kSize, ShadowMap::kSize);
  glTextureParameteri(texture.id(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(texture.id(), GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  const float lit[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glTextureParameterfv(texture.id(), GL_TEXTURE_BORDER_COLOR, lit);
  return texture;
}

GlFramebuffer MakeDepthFramebuffer(GLuint texture) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, texture, 0);
  glNamedFramebufferDrawBuffer(id, GL_NONE);
  return GlFramebuffer(id);
}

}  // namespace

core::Result<ShadowMap> ShadowMap::Create() {
  ShadowMap map;
  auto program = MakeProgram("shadow", kShadowVertex, kShadowFragment);
  if (!program) return tl::unexpected(program.error());
  map.program_ = std::move(*program);
  map.depth_ = MakeDepthTexture();
  map.static_depth_ = MakeDepthTexture();
  map.framebuffer_ = MakeDepthFramebuffer(map.depth_.id());
  map.static_framebuffer_ = MakeDepthFramebuffer(map.static_depth_.id());
  return map;
}

void ShadowMap::Fit(const glm::dvec3& sun_direction_W, const glm::dvec3& centre_W, double radius_m) {
  sun_W_ = glm::mat4(view::SunMatrix(sun_direction_W, centre_W, radius_m));
  texel_m_ = static_cast<float>(2.0 * radius_m / kSize);
  is_static_drawn_ = false;
  drawn_.clear();
}

std::uint64_t ShadowMap::VersionOfSheets(const view::Scene& scene) {
  std::uint64_t sum = 0;
  for (const view::Sheet& sheet : scene.sheets) sum += sheet.version;
  return sum;
}

std::vector<bool> ShadowMap::CastersOf(const view::Scene& scene) {
  std::vector<bool> casters;
  for (const view::Instance& instance : scene.instances) {
    casters.push_back(instance.is_visible && instance.opacity >= 1.0f);
  }
  return casters;
}

bool ShadowMap::HasMoved(const view::Scene& scene) const {
  if (drawn_.size() != scene.instances.size() || drawn_sheets_ != VersionOfSheets(scene)) return true;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const core::Pose& X_WM = scene.instances[i].X_WM;
    if (scene.instances[i].posture != drawn_postures_[i]) return true;
    // Motion below 0.1 mm or 0.9 mrad is far smaller than a texel. With the unit quaternions' product c the angle
    // between two rotations is 2 acos |c|.
    if (glm::distance(X_WM.translation, drawn_[i].translation) > 1e-4) return true;
    if (std::abs(glm::dot(X_WM.rotation, drawn_[i].rotation)) < 1.0 - 1e-7) return true;
  }
  return false;
}

void ShadowMap::DrawCasters(const view::Scene& scene, const std::vector<GpuMesh>& meshes, bool is_movable) const {
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    if (!casters_[i] || instance.is_movable != is_movable) continue;
    const GpuMesh& mesh = meshes[instance.mesh];
    if (IsOutside(sun_W_, glm::vec3(instance.X_WM * glm::dvec3(mesh.centre_M)), mesh.radius_m)) continue;
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(ToMatrix(instance.X_WM)));
    glBindVertexArray(mesh.layout.id());
    glDrawElements(GL_TRIANGLES, mesh.num_indices, GL_UNSIGNED_INT, nullptr);
  }
}

void ShadowMap::Update(const view::Scene& scene, const std::vector<GpuMesh>& meshes,
                       const std::vector<GpuMesh>& sheets) {
  std::vector<bool> casters = CastersOf(scene);
  if (casters != casters_) {
    casters_ = std::move(casters);
    is_static_drawn_ = false;
  }
  if (is_static_drawn_ && !HasMoved(scene)) return;
  ++num_updates_;
  drawn_.clear();
  drawn_sheets_ = VersionOfSheets(scene);
  drawn_postures_.clear();
  for (const view::Instance& instance : scene.instances) {
    drawn_.push_back(instance.X_WM);
    drawn_postures_.push_back(instance.posture);
  }

  glViewport(0, 0, kSize, kSize);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glEnable(GL_DEPTH_CLAMP);  // what is nearer to the sun than the map begins casts its shadow all the same
  glPolygonOffset(1.5f, 2.0f);
  glUseProgram(program_.id());
  glUniformMatrix4fv(1, 1, GL_FALSE, glm::value_ptr(sun_W_));
  const float far = 1.0f;
  if (!is_static_drawn_) {
    glBindFramebuffer(GL_FRAMEBUFFER, static_framebuffer_.id());
    glClearBufferfv(GL_DEPTH, 0, &far);
    DrawCasters(scene, meshes, false);
    is_static_drawn_ = true;
  }
  glCopyImageSubData(static_depth_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, depth_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, kSize,
                     kSize, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  DrawCasters(scene, meshes, true);
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(glm::mat4(1.0f)));
  for (const GpuMesh& sheet : sheets) {
    glBindVertexArray(sheet.layout.id());
    glDrawElements(GL_TRIANGLES, sheet.num_indices, GL_UNSIGNED_INT, nullptr);
  }
  glDisable(GL_DEPTH_CLAMP);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

}  // namespace visual_node
