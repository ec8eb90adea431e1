#include "view/appearance/mip_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "view/appearance/tone_curve.hpp"

namespace view {
namespace {

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

const std::array<float, 256>& CodeValues(bool is_color) {
  static const Codes codes;
  return is_color ? codes.color : codes.number;
}

MipLevel Halve(const MipLevel& level, bool is_color) {
  const std::array<float, 256>& values = CodeValues(is_color);
  MipLevel half{std::max(1, level.width / 2), std::max(1, level.height / 2), {}};
  half.texels.reserve(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
  const auto at = [&](int x, int y) {
    x = std::min(x, level.width - 1);
    y = std::min(y, level.height - 1);
    const glm::u8vec4& texel = level.texels[static_cast<std::size_t>(y * level.width + x)];
    return glm::vec4(values[texel.r], values[texel.g], values[texel.b], static_cast<float>(texel.a) / 255.0f);
  };
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const glm::vec4 mean =
          0.25f * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1));
      const glm::vec3 code = is_color ? EncodeSrgb(glm::vec3(mean)) : glm::vec3(mean);
      half.texels.emplace_back(255.0f * glm::vec4(code, mean.a) + 0.5f);
    }
  }
  return half;
}

}  // namespace

float CodeValue(std::uint8_t code, bool is_color) {
  return CodeValues(is_color)[code];
}

std::vector<MipLevel> MipLevels(const vps::VisualTexture& picture) {
  std::vector<MipLevel> levels;
  MipLevel& first = levels.emplace_back(MipLevel{picture.width, picture.height, {}});
  first.texels.resize(picture.rgba.size() / 4);
  std::memcpy(first.texels.data(), picture.rgba.data(), 4 * first.texels.size());
  while (levels.back().width > 1 || levels.back().height > 1) {
    levels.push_back(Halve(levels.back(), picture.is_color));
  }
  return levels;
}

}  // namespace view
