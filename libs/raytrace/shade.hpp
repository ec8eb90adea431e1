#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "view/appearance/environment_light.hpp"

namespace raytrace {

// Where a ray meets a surface, and what the surface is made of there. The formulas, and what their letters mean, are
// those of the OpenGL renderer (nodes/visual_node/draw/surface_shaders.hpp), so that both show the same materials.
struct Surface {
  glm::vec3 p_W{0.0f};
  glm::vec3 n_W{0.0f};         // towards the eye; with bumps and wrinkles
  glm::vec3 smooth_n_W{0.0f};  // without them
  glm::vec3 v_W{0.0f};         // to the eye
  glm::vec3 p_WOut{0.0f};      // where rays that leave the surface begin
  glm::vec3 base{0.8f};
  glm::vec3 emissive{0.0f};
  glm::vec3 along_W{0.0f};  // of foil: the direction in which it was rolled
  float metallic = 0.0f;
  float roughness = 0.6f;
  float open = 1.0f;  // the share of the surroundings that reaches it
  float coat = 0.0f;  // the share that lacquer covers
  float coat_roughness = 0.0f;
  float transmission = 0.0f;  // of the light that is not mirrored, how much goes through
  float ior = 1.5f;
  bool is_foil = false;
  bool is_back = false;  // of the triangle; of glass: the ray comes from inside
};

struct Lamp {
  glm::vec3 p_W{0.0f};
  float reach_m = 0.0f;
  glm::vec3 color{0.0f};
};

// All light that does not depend on what hides it.
class Lighting {
 public:
  Lighting();
  void Set(const view::EnvironmentLight& light, std::vector<Lamp> lamps);

  [[nodiscard]] const glm::vec3& to_sun_W() const { return light_.sun_direction_W; }
  // From the direction d_W, in a lobe of half-angle a [rad].
  [[nodiscard]] glm::vec3 Environment(const glm::vec3& d_W, float a) const;

  // What a surface sends to the eye.
  struct Parts {
    glm::vec3 sun{0.0f};     // when nothing stands before the sun
    glm::vec3 mirror{0.0f};  // the share of the light from `mirror_W`
    glm::vec3 mirror_W{0.0f};
    float lobe_rad = 0.0f;
    glm::vec3 ambient{0.0f};  // of the light around, when nothing near hides it
    glm::vec3 through{0.0f};  // the share of the light from behind
    glm::vec3 rest{0.0f};
  };
  [[nodiscard]] Parts Reflect(const Surface& surface) const;

 private:
  void Coat(const Surface& surface, Parts* parts) const;
  [[nodiscard]] glm::vec3 Irradiance(const glm::vec3& n) const;
  [[nodiscard]] glm::vec2 SplitSum(float nv, float roughness) const;

  view::EnvironmentLight light_;
  std::array<glm::vec3, 9> irradiance_{};
  std::vector<Lamp> lamps_;
  std::vector<glm::vec2> split_sum_;
};

}  // namespace raytrace
