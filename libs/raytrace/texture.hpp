#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "view/appearance/mip_levels.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace raytrace {

// A texture's picture with its smaller levels, repeated in both directions. As OpenGL samples it: four neighbours of
// the level whose texels are nearest to the size asked for; of colours the light is mixed, not the codes.
class Texture {
 public:
  explicit Texture(const vps::VisualTexture& picture);

  // Red, green and blue at (u, v), v downwards, in [0, 1], linear. `span`: how far texture coordinates change over a
  // pixel, in units of the whole picture.
  [[nodiscard]] glm::vec3 At(const glm::vec2& uv, float span) const;

 private:
  bool is_color_ = false;
  std::vector<view::MipLevel> levels_;  // the largest first
};

}  // namespace raytrace
