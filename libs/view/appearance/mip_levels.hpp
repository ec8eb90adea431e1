#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/load_mesh.hpp"

namespace view {

struct MipLevel {
  int width = 0;
  int height = 0;
  std::vector<glm::u8vec4> texels;  // row by row from the top
};

// A texture's picture, and halves of it down to one texel: each texel is the mean of four. Of colours the light is
// mixed, not the codes.
std::vector<MipLevel> MipLevels(const vps::VisualTexture& picture);

// What a code stands for: the light of a colour's (sRGB), or the number itself.
float CodeValue(std::uint8_t code, bool is_color);

}  // namespace view
