#include "raytrace/texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "view/appearance/tone_curve.hpp"

namespace raytrace {
namespace {

// The light of each code of sRGB, and the code's own number where it is no colour.
struct Codes {
  std::array<float, 256> color{}, number{};
  Codes() {
    for (std::size_t i = 0; i < 256; ++i) {
      const float v = static_cast<float>(i) / 255.0f;
      number[i] = v;
      color[i] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
    }
  }
};

const Codes& AllCodes() {
  static const Codes codes;
  return codes;
}

}  // namespace

Texture::Texture(const vps::VisualTexture& picture) : is_color_(picture.is_color) {
  Level level{picture.width, picture.height, {}};
  level.texels.resize(picture.rgba.size() / 4);
  std::memcpy(level.texels.data(), picture.rgba.data(), 4 * level.texels.size());
  levels_.push_back(std::move(level));
  while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(Halve(levels_.back()));
}

glm::vec3 Texture::Decode(const glm::u8vec4& texel) const {
  const std::array<float, 256>& codes = is_color_ ? AllCodes().color : AllCodes().number;
  return {codes[texel.r], codes[texel.g], codes[texel.b]};
}

Texture::Level Texture::Halve(const Level& level) const {
  Level half{std::max(1, level.width / 2), std::max(1, level.height / 2), {}};
  const auto at = [&](int x, int y) {
    x = std::min(x, level.width - 1);
    y = std::min(y, level.height - 1);
    return Decode(level.texels[static_cast<std::size_t>(y * level.width + x)]);
  };
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const glm::vec3 sum = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
      const glm::vec3 code = 255.0f * (is_color_ ? view::EncodeSrgb(0.25f * sum) : 0.25f * sum) + 0.5f;
      half.texels.emplace_back(glm::u8vec3(code), 255);
    }
  }
  return half;
}

glm::vec3 Texture::At(const glm::vec2& uv, float span) const {
  const auto longest = static_cast<float>(std::max(levels_[0].width, levels_[0].height));
  std::size_t number = 0;
  // The next level from sqrt(2) texels for each pixel on.
  for (float texels = span * longest; texels > 1.41421356f && number + 1 < levels_.size(); texels *= 0.5f) ++number;
  const Level& level = levels_[number];
  const float x = (uv.x - std::floor(uv.x)) * static_cast<float>(level.width) - 0.5f;
  const float y = (uv.y - std::floor(uv.y)) * static_cast<float>(level.height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const auto wrap = [](int i, int size) { return i < 0 ? i + size : (i >= size ? i - size : i); };
  const int x0 = wrap(static_cast<int>(left), level.width), x1 = wrap(static_cast<int>(left) + 1, level.width);
  const int y0 = wrap(static_cast<int>(top), level.height), y1 = wrap(static_cast<int>(top) + 1, level.height);
  const auto at = [&](int i, int k) { return Decode(level.texels[static_cast<std::size_t>(k * level.width + i)]); };
  const float s = x - left, t = y - top;
  return glm::mix(glm::mix(at(x0, y0), at(x1, y0), s), glm::mix(at(x0, y1), at(x1, y1), s), t);
}

}  // namespace raytrace
