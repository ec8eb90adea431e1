#include "nodes/visual_node/draw/surface_painter.hpp"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <sstream>
#include <string>

#include "nodes/visual_node/draw/surface_shaders.hpp"
#include "view/appearance/foil.hpp"
#include "view/appearance/split_sum.hpp"

namespace visual_node {
namespace {

constexpr std::size_t kFoil = 1, kSoft = 2, kBaseMap = 4, kSurfaceMap = 8, kNormalMap = 16, kGlowMap = 32, kCoat = 64,
                      kLamps = 128;

// Foil has its own wrinkles, no textures and no lacquer.
std::size_t TexturesOf(const GpuMesh::Look& look) {
  return (look.base_texture >= 0 ? kBaseMap : 0) + (look.surface_texture >= 0 ? kSurfaceMap : 0) +
         (look.normal_texture >= 0 ? kNormalMap : 0) + (look.emissive_texture >= 0 ? kGlowMap : 0);
}

// Beyond so many times its reach a lamp adds less than half a code to a dark surface.
constexpr float kLampReaches = 7.0f;

// Whether one of the lamps lights a part of the mesh's bounding box.
bool HasLampNear(const std::vector<SurfaceFrame::Lamp>& lamps, const GpuMesh& mesh, const glm::mat4& X_WM) {
  const glm::mat3 R_MW = glm::transpose(glm::mat3(X_WM));
  return std::any_of(lamps.begin(), lamps.end(), [&](const SurfaceFrame::Lamp& lamp) {
    const glm::vec3 from_centre_M = R_MW * (glm::vec3(lamp.position_W) - glm::vec3(X_WM[3])) - mesh.centre_M;
    const glm::vec3 outside_M = glm::max(glm::abs(from_centre_M) - mesh.half_size_m, 0.0f);
    return glm::length(outside_M) < kLampReaches * lamp.position_W.w;
  });
}

// Eight bits without sign are what a software renderer filters fastest.
std::vector<view::MipLevel> Wrinkles() {
  vps::VisualTexture picture{view::kFoilSize, view::kFoilSize, {}, false};
  for (const glm::vec3& tilt : view::FoilTilts()) {
    const glm::vec3 share(0.5f * tilt.x + 0.5f, 0.5f * tilt.y + 0.5f, tilt.z);
    const glm::u8vec3 codes(255.0f * glm::clamp(share, 0.0f, 1.0f) + 0.5f);
    picture.rgba.insert(picture.rgba.end(), {codes.x, codes.y, codes.z, 255});
  }
  return view::MipLevels(picture);
}

// What does not change is cheaper as a constant than as a uniform.
std::string LightPanels() {
  std::ostringstream text;
  for (std::size_t i = 0; i < view::kPanels.size(); ++i) {
    const view::LightPanel& panel = view::kPanels[i];
    const glm::vec3& d = panel.direction_W;
    text << "const vec4 kPanel" << i << " = vec4(" << d.x << "," << d.y << "," << d.z << "," << panel.strength << ");\n"
         << "const vec2 kPanelEdge" << i << " = vec2(" << panel.outer << "," << panel.inner << ");\n";
  }
  return text.str();
}

// Reads the shadow map's depths instead of comparing them.
GlSampler MakeDepthSampler() {
  GLuint id = 0;
  glCreateSamplers(1, &id);
  glSamplerParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_NONE);
  glSamplerParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glSamplerParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glSamplerParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glSamplerParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  const float lit[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glSamplerParameterfv(id, GL_TEXTURE_BORDER_COLOR, lit);
  return GlSampler(id);
}

}  // namespace

SurfaceTables SurfaceTables::Make() {
  return {view::SplitSumTable(), Wrinkles()};
}

core::Result<SurfacePainter> SurfacePainter::Create(const SurfaceTables& tables) {
  SurfacePainter painter;
  for (const std::size_t variant : {std::size_t{0}, kFoil}) {
    if (auto compiled = painter.Compile(variant); !compiled) return tl::unexpected(compiled.error());
  }
  painter.split_sum_ = MakeTexture(GL_RG32F, view::kSplitSumSize, view::kSplitSumSize);
  glTextureSubImage2D(painter.split_sum_.id(), 0, 0, 0, view::kSplitSumSize, view::kSplitSumSize, GL_RG, GL_FLOAT,
                      tables.split_sum.data());
  painter.wrinkles_ = UploadTexture(tables.wrinkles, false);
  painter.depth_sampler_ = MakeDepthSampler();
  painter.irradiance_ = view::Irradiance(painter.irradiance_of_);
  return painter;
}

core::Result<void> SurfacePainter::Compile(std::size_t variant) {
  if (programs_[variant].id() != 0) return {};
  std::string head = "#version 450 core\n";
  constexpr const char* kNames[] = {"FOIL",       "SOFT",     "BASE_MAP", "SURFACE_MAP",
                                    "NORMAL_MAP", "GLOW_MAP", "COAT",     "LAMPS"};
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if ((variant >> i & 1) != 0) head += std::string("#define ") + kNames[i] + "\n";
  }
  head += kIrradiance;
  head += LightPanels();
  auto program = MakeProgram("surface", (head + kSurfaceVertex).c_str(), (head + kSurfaceFragment).c_str());
  if (!program) return tl::unexpected(program.error());
  programs_[variant] = std::move(*program);
  return {};
}

core::Result<void> SurfacePainter::Prepare(const GpuMesh& mesh) {
  const auto prepare = [&](const GpuMesh::Look& look) -> core::Result<void> {
    if (look.material.is_foil) return {};
    return Compile(TexturesOf(look) + (look.material.coat > 0.0f ? kCoat : 0));
  };
  for (const GpuMesh::Part& part : mesh.parts) {
    if (auto prepared = prepare(part); !prepared) return prepared;
    for (const GpuMesh::Look& variant : part.variants) {
      if (auto prepared = prepare(variant); !prepared) return prepared;
    }
  }
  return {};
}

void SurfacePainter::Begin(const SurfaceFrame& frame, const ShadowMap& shadow) {
  frame_ = frame;
  sun_W_ = shadow.sun_W();
  shadow_offset_m_ = 1.5f * shadow.texel_m();
  if (frame.light != irradiance_of_) {
    irradiance_of_ = frame.light;
    irradiance_ = view::Irradiance(frame.light);
  }
  is_ready_.fill(false);
  glBindTextureUnit(0, shadow.texture());
  glBindTextureUnit(1, split_sum_.id());
  glBindTextureUnit(2, shadow.texture());
  glBindSampler(2, depth_sampler_.id());
  glBindTextureUnit(3, wrinkles_.id());
}

void SurfacePainter::Use(std::size_t variant) {
  if (is_ready_[variant] && variant == used_) return;
  // With a penumbra, which the first picture of a window does not wait for, or with lamps, or of a material that no
  // mesh has. The driver has compiled this shader for others.
  if (programs_[variant].id() == 0 && !Compile(variant)) variant &= kFoil;
  glUseProgram(programs_[variant].id());
  used_ = variant;
  if (is_ready_[variant]) return;
  is_ready_[variant] = true;
  const view::EnvironmentLight& light = frame_.light;
  glUniform1f(3, shadow_offset_m_);
  glUniform3fv(7, 1, glm::value_ptr(light.sun_direction_W));
  const auto num_lamps = (variant & kLamps) == 0 ? 0 : static_cast<GLint>(std::min(frame_.lamps.size(), kMaxLamps));
  for (GLint i = 0; i < num_lamps; ++i) {
    const SurfaceFrame::Lamp& lamp = frame_.lamps[static_cast<std::size_t>(i)];
    glUniform4fv(8 + i, 1, glm::value_ptr(lamp.position_W - glm::vec4(frame_.eye_W, 0.0f)));
    glUniform3fv(12 + i, 1, glm::value_ptr(lamp.color));
  }
  if (num_lamps > 0) glUniform1i(16, num_lamps);
  glUniform4f(17, light.earth_direction_W.x, light.earth_direction_W.y, light.earth_direction_W.z, light.earth_sine);
  glUniform3fv(18, 1, glm::value_ptr(light.sun));
  glUniform3fv(19, 1, glm::value_ptr(light.earth));
  glUniform3fv(20, 1, glm::value_ptr(light.panels));
  glUniform3fv(21, 1, glm::value_ptr(light.everywhere));
  glUniform3fv(26, 9, glm::value_ptr(irradiance_[0]));
}

void SurfacePainter::Draw(const GpuMesh& mesh, const GpuMesh::Part& part, const GpuMesh::Look& look,
                          const glm::mat4& X_WM, const view::Material& material, bool with_textures) {
  Draw(mesh, look, X_WM, material, with_textures, mesh.layout.id(), {part.num_indices, part.first_byte});
}

void SurfacePainter::Draw(const GpuMesh& mesh, const GpuMesh::Look& look, const glm::mat4& X_WM,
                          const view::Material& m, bool with_textures, GLuint layout,
                          const PickedTriangles::Run& triangles) {
  if (triangles.num_indices == 0) return;
  const bool is_textured = with_textures && !m.is_foil;
  const bool is_coated = m.coat > 0.0f && !m.is_foil;
  Use((m.is_foil ? kFoil : 0) + (frame_.has_soft_shadows ? kSoft : 0) + (is_textured ? TexturesOf(look) : 0) +
      (is_coated ? kCoat : 0) + (HasLampNear(frame_.lamps, mesh, X_WM) ? kLamps : 0));
  if (is_textured) {
    const auto bind = [&](GLuint unit, int texture) {
      if (texture >= 0) glBindTextureUnit(unit, mesh.textures[static_cast<std::size_t>(texture)].id());
    };
    bind(4, look.base_texture);
    bind(5, look.surface_texture);
    bind(6, look.normal_texture);
    bind(7, look.emissive_texture);
    if (look.surface_texture >= 0) glUniform1f(35, look.has_occlusion ? 1.0f : 0.0f);
  }
  if (is_coated) glUniform2f(36, m.coat, m.coat_roughness);
  glm::mat4 X_EM = X_WM;
  X_EM[3] -= glm::vec4(frame_.eye_W, 0.0f);
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(X_EM));
  glUniformMatrix4fv(1, 1, GL_FALSE, glm::value_ptr(frame_.clip_W * X_WM));
  glUniformMatrix4fv(2, 1, GL_FALSE, glm::value_ptr(sun_W_ * X_WM));
  glUniform4f(4, m.base_color.r, m.base_color.g, m.base_color.b, m.metallic);
  glUniform4f(5, m.emissive.r, m.emissive.g, m.emissive.b, m.roughness);
  if (look.is_two_sided) {
    glDisable(GL_CULL_FACE);
  } else {
    glEnable(GL_CULL_FACE);  // of OpenGL's initial state: faces whose corners run clockwise
  }
  glBindVertexArray(layout);
  // OpenGL passes an offset into the bound buffer as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
  const auto* const offset = reinterpret_cast<const void*>(triangles.first_byte);
  glDrawElements(GL_TRIANGLES, triangles.num_indices, GL_UNSIGNED_INT, offset);
}

}  // namespace visual_node
