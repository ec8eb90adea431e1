#pragma once

#include <array>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/draw/detail_picker.hpp"
#include "nodes/visual_node/draw/shadow_map.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "nodes/visual_node/gl/mesh_store.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/appearance/mip_levels.hpp"

namespace visual_node {

// What all surfaces of a picture have in common.
struct SurfaceFrame {
  struct Lamp {
    glm::vec4 position_W;  // w: reach [m]
    glm::vec3 color;
  };
  glm::mat4 clip_W{1.0f};
  glm::vec3 eye_W{0.0f};
  bool has_soft_shadows = false;
  view::EnvironmentLight light;
  std::vector<Lamp> lamps;  // the first kMaxLamps shine
};

// Computed once, without OpenGL.
struct SurfaceTables {
  std::vector<glm::vec2> split_sum;      // view::SplitSumTable
  std::vector<view::MipLevel> wrinkles;  // view::FoilTilts, those along x and y from -1 to 1

  static SurfaceTables Make();
};

// Draws meshes with materials in the light of sun, Earth and lamps (surface_shaders.hpp). For a software renderer there
// is one shader for each kind of surface: it executes both sides of a branch. Those with textures are compiled when a
// mesh needs them.
class SurfacePainter {
 public:
  static constexpr std::size_t kMaxLamps = 4;  // of the shader's arrays

  static core::Result<SurfacePainter> Create(const SurfaceTables& tables);

  // Once for each mesh that will be drawn. Error: kUnsupported, when the driver cannot compile a shader.
  core::Result<void> Prepare(const GpuMesh& mesh);

  // Before the first Draw of each picture. The shadow map stays valid until the last one.
  void Begin(const SurfaceFrame& frame, const ShadowMap& shadow);
  // The part with one of its looks, or another material.
  void Draw(const GpuMesh& mesh, const GpuMesh::Part& part, const GpuMesh::Look& look, const glm::mat4& X_WM,
            const view::Material& material, bool with_textures = true);
  // Of a part only these triangles, which are indices in the layout's buffer.
  void Draw(const GpuMesh& mesh, const GpuMesh::Look& look, const glm::mat4& X_WM, const view::Material& material,
            bool with_textures, GLuint layout, const PickedTriangles::Run& triangles);

 private:
  static constexpr std::size_t kNumVariants = 256;

  core::Result<void> Compile(std::size_t variant);
  void Use(std::size_t variant);

  std::array<GlProgram, kNumVariants> programs_;  // index: surface_painter.cpp's sum of kinds
  std::array<bool, kNumVariants> is_ready_{};     // has this picture's uniforms
  std::size_t used_ = 0;
  GlTexture split_sum_;
  GlTexture wrinkles_;
  GlSampler depth_sampler_;
  SurfaceFrame frame_;
  glm::mat4 sun_W_{1.0f};
  float shadow_offset_m_ = 0.0f;
  view::EnvironmentLight irradiance_of_;
  std::array<glm::vec3, 9> irradiance_{};
};

}  // namespace visual_node
