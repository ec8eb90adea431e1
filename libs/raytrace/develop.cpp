#include "raytrace/develop.hpp"

#include <cmath>

#include "view/appearance/tone_curve.hpp"

namespace raytrace {

picture::Image Develop(const picture::Measured<float>& light, float exposure) {
  picture::Image image(light.width, light.height);
  for (std::size_t i = 0; 4 * i < image.rgba.size(); ++i) {
    const glm::vec3 seen(light.values[3 * i], light.values[3 * i + 1], light.values[3 * i + 2]);
    const glm::vec3 code = view::EncodeSrgb(glm::clamp(view::ToneCurve(exposure * seen), 0.0f, 1.0f));
    for (std::size_t k = 0; k < 3; ++k) {
      image.rgba[4 * i + k] = static_cast<std::uint8_t>(std::lround(255.0f * code[static_cast<int>(k)]));
    }
    image.rgba[4 * i + 3] = 255;
  }
  return image;
}

}  // namespace raytrace
