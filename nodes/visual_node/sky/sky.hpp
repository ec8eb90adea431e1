#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"
#include "nodes/visual_node/sky/ground.hpp"
#include "space/atmosphere/from_space.hpp"
#include "space/stars/star_field.hpp"
#include "space/surroundings.hpp"

namespace visual_node {

// What the sky needs that takes long and no OpenGL. Error: kDamaged.
struct SkyData {
  Ground ground;
  std::vector<std::vector<std::uint8_t>> fine;  // FineStructure, and halves of it down to one point
  space::StarField stars;
  std::string note;  // what is missing of the stars; empty: nothing

  static core::Result<SkyData> Make();
};

// What is far away: stars, sun, Moon, and the Earth with its air. The stars are splatted by the CPU, anew when the
// camera turns. The Earth's surface is a cube map in its own frame; its tiles are computed when they come into view.
class Sky {
 public:
  static core::Result<Sky> Create(const SkyData& data);

  // From the next picture on. Until then the Earth has no air.
  void SetAir(const space::AirFromSpace& air);
  [[nodiscard]] const space::AirFromSpace& air() const { return air_; }

  // Before the target is bound: computes what has come into view.
  void Prepare(const space::Surroundings& space, const space::StarCamera& camera);

  // After the surfaces: fills the pixels at the far plane. `clip_sky` is the clip matrix without the translation of the
  // eye. The target has the size of Prepare's camera.
  void Draw(const space::Surroundings& space, const glm::mat4& clip_sky) const;

  // What is missing of the stars; empty: nothing.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  void BakeVisible(const space::Surroundings& space);
  void Splat(const space::StarCamera& camera);
  void DrawBackground(const space::Surroundings& space, const glm::mat4& clip_sky, const glm::vec3& sun) const;
  void DrawEarth(const space::Surroundings& space, const glm::mat4& clip_sky, const glm::vec3& sun) const;

  GlProgram star_light_, sun_, moon_;
  GlProgram ground_;
  GlProgram earth_;
  GlTexture cube_;
  GlTexture lights_cube_;
  GlTexture land_;
  GlTexture clouds_;
  GlTexture fine_;
  GlTexture lights_;
  GlTexture stars_;
  space::AirFromSpace air_;
  GlTexture scattering_;
  GlTexture through_;
  GlTexture ground_light_;
  GlFramebuffer bake_;
  GlVertexArray nothing_;       // the core profile requires one, even when the shader generates its vertices
  std::vector<bool> is_baked_;  // tiles of the cube
  std::optional<space::StarField> field_;
  space::StarCamera splatted_;
  std::vector<glm::vec4> luminance_;
  std::string note_;
};

}  // namespace visual_node
