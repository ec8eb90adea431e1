#include "nodes/visual_node/draw/shadow_map.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

#include "nodes/visual_node/draw/shaders.hpp"
#include "nodes/visual_node/gl/matrix.hpp"
#include "view/projection.hpp"

namespace visual_node {
namespace {

constexpr double kExact_m = 1e-4;      // far smaller than a texel
constexpr float kSlack_texels = 0.5f;  // less than what the map is sampled off the surface

// Whether a point within the radius may be farther off than the slack. With the unit quaternions' product c the angle
// between two rotations is 2 acos |c|, for small ones sqrt(8 (1 - |c|)).
bool IsOff(const core::Pose& now, const core::Pose& then, double radius_m, double slack_m) {
  const double turned_rad = std::sqrt(8.0 * std::max(0.0, 1.0 - std::abs(glm::dot(now.rotation, then.rotation))));
  return glm::distance(now.translation, then.translation) + turned_rad * radius_m > slack_m;
}

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

bool ShadowMap::HasMoved(const view::Scene& scene, const std::vector<GpuMesh>& meshes, double slack_m) const {
  if (drawn_.size() != scene.instances.size()) return true;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    const double radius_m = meshes[instance.mesh].radius_m;
    if (IsOff(instance.X_WM, drawn_[i], radius_m, slack_m)) return true;
    const view::Posture &now = instance.posture, &then = drawn_postures_[i];
    if (now == then) continue;
    if (now == nullptr || then == nullptr || now->size() != then->size()) return true;
    for (std::size_t k = 0; k < now->size(); ++k) {
      if (IsOff((*now)[k], (*then)[k], radius_m, slack_m)) return true;
    }
  }
  return HaveSheetsMoved(scene, slack_m);
}

bool ShadowMap::HaveSheetsMoved(const view::Scene& scene, double slack_m) const {
  if (drawn_sheets_ == VersionOfSheets(scene)) return false;
  if (drawn_nodes_.size() != scene.sheets.size()) return true;
  for (std::size_t i = 0; i < drawn_nodes_.size(); ++i) {
    const std::vector<glm::vec3>&now = scene.sheets[i].p_W, &then = drawn_nodes_[i];
    if (now.size() != then.size()) return true;
    for (std::size_t k = 0; k < now.size(); ++k) {
      if (glm::distance(now[k], then[k]) > slack_m) return true;
    }
  }
  return false;
}

void ShadowMap::DrawCasters(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const Coarse& coarse,
                            bool is_movable) const {
  struct Caster {
    glm::mat4 X_WM;
    GLuint layout;
    PickedTriangles::Run triangles;
  };
  std::vector<Caster> casters;
  if (coarse.picked != nullptr) coarse.picked->Clear();
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    if (!casters_[i] || instance.is_movable != is_movable) continue;
    const GpuMesh& mesh = meshes[instance.mesh];
    if (IsOutside(sun_W_, glm::vec3(instance.X_WM * glm::dvec3(mesh.centre_M)), mesh.radius_m)) continue;
    Caster caster{ToMatrix(instance.X_WM), mesh.layout.id(), {mesh.num_indices, 0}};
    const DetailedMesh* detail = coarse.details != nullptr ? &(*coarse.details)[instance.mesh] : nullptr;
    if (detail != nullptr && !detail->levels.is_empty()) {
      const auto parts = coarse.picked->Add(detail->levels, {sun_W_ * caster.X_WM, kSlack_texels * texel_m_, 0.0f});
      caster.layout = detail->layout.id();
      caster.triangles = {0, parts.front().first_byte};
      for (const PickedTriangles::Run& part : parts) caster.triangles.num_indices += part.num_indices;
    }
    casters.push_back(caster);
  }
  if (coarse.picked != nullptr) coarse.picked->Upload();
  for (const Caster& caster : casters) {
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(caster.X_WM));
    glBindVertexArray(caster.layout);
    // OpenGL passes an offset into the bound buffer as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
    const auto* const offset = reinterpret_cast<const void*>(caster.triangles.first_byte);
    glDrawElements(GL_TRIANGLES, caster.triangles.num_indices, GL_UNSIGNED_INT, offset);
  }
}

void ShadowMap::Update(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const std::vector<GpuMesh>& sheets,
                       const Coarse& coarse) {
  const bool is_exact = coarse.details == nullptr;
  if (is_exact && !is_static_exact_) is_static_drawn_ = false;
  std::vector<bool> casters = CastersOf(scene);
  if (casters != casters_) {
    casters_ = std::move(casters);
    is_static_drawn_ = false;
  }
  const double slack_m = is_exact ? kExact_m : kSlack_texels * texel_m_;
  if (is_static_drawn_ && (is_exact_ || !is_exact) && !HasMoved(scene, meshes, slack_m)) return;
  is_exact_ = is_exact;
  ++num_updates_;
  drawn_.clear();
  drawn_sheets_ = VersionOfSheets(scene);
  drawn_postures_.clear();
  drawn_nodes_.clear();
  for (const view::Sheet& sheet : scene.sheets) drawn_nodes_.push_back(sheet.p_W);
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
    DrawCasters(scene, meshes, coarse, false);
    is_static_drawn_ = true;
    is_static_exact_ = is_exact;
  }
  glCopyImageSubData(static_depth_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, depth_.id(), GL_TEXTURE_2D, 0, 0, 0, 0, kSize,
                     kSize, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  DrawCasters(scene, meshes, coarse, true);
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(glm::mat4(1.0f)));
  for (const GpuMesh& sheet : sheets) {
    glBindVertexArray(sheet.layout.id());
    glDrawElements(GL_TRIANGLES, sheet.num_indices, GL_UNSIGNED_INT, nullptr);
  }
  glDisable(GL_DEPTH_CLAMP);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

}  // namespace visual_node
