#include "raytrace/texture.hpp"

#include <algorithm>
#include <cmath>

namespace raytrace {

Texture::Texture(const vps::VisualTexture& picture) : is_color_(picture.is_color), levels_(view::MipLevels(picture)) {}

glm::vec3 Texture::At(const glm::vec2& uv, float span) const {
  const auto longest = static_cast<float>(std::max(levels_[0].width, levels_[0].height));
  std::size_t number = 0;
  // The next level from sqrt(2) texels for each pixel on.
  for (float texels = span * longest; texels > 1.41421356f && number + 1 < levels_.size(); texels *= 0.5f) ++number;
  const view::MipLevel& level = levels_[number];
  const float x = (uv.x - std::floor(uv.x)) * static_cast<float>(level.width) - 0.5f;
  const float y = (uv.y - std::floor(uv.y)) * static_cast<float>(level.height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const auto wrap = [](int i, int size) { return i < 0 ? i + size : (i >= size ? i - size : i); };
  const int x0 = wrap(static_cast<int>(left), level.width), x1 = wrap(static_cast<int>(left) + 1, level.width);
  const int y0 = wrap(static_cast<int>(top), level.height), y1 = wrap(static_cast<int>(top) + 1, level.height);
  const auto at = [&](int i, int k) {
    const glm::u8vec4& texel = level.texels[static_cast<std::size_t>(k * level.width + i)];
    return glm::vec3(view::CodeValue(texel.r, is_color_), view::CodeValue(texel.g, is_color_),
                     view::CodeValue(texel.b, is_color_));
  };
  const float s = x - left, t = y - top;
  return glm::mix(glm::mix(at(x0, y0), at(x1, y0), s), glm::mix(at(x0, y1), at(x1, y1), s), t);
}

}  // namespace raytrace
