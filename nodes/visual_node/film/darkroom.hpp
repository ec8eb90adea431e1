#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

namespace visual_node {

// The geometric mean of the luminance of bodies, by 16 samples of each cell of a grid; none when it shows only space.
// `light` and `film` as below.
std::optional<float> MeanLuminanceOf(std::span<const std::uint16_t> light, const glm::ivec2& film,
                                     const glm::ivec2& cells);

// Develops a film's light without OpenGL: exposure, tone curve, sRGB, smooth edges and the target's size, by the
// formulas of film_shaders.hpp. Where OpenGL is software, too, shaders take more of the processor for it: they
// smooth every pixel, also those without an edge, and an enlarged picture is another pass.
class Darkroom {
 public:
  // `light`: four 16-bit floats for each pixel of the film, linear RGB and alpha as Film has it, the lowest row first.
  // Returns the picture of the target's size: red, green, blue and 255 in four bytes, the lowest row first. It is valid
  // until the next call.
  std::span<const std::uint32_t> Develop(std::span<const std::uint16_t> light, const glm::ivec2& film, float exposure,
                                         const glm::ivec2& target);

 private:
  void Smooth(const glm::ivec2& film);
  void Enlarge(const glm::ivec2& film, const glm::ivec2& target);

  std::vector<float> row_;                // of light
  std::vector<std::uint32_t> developed_;  // alpha: the luma that edges are found by
  std::vector<std::uint8_t> lumas_;       // these once more, with a frame of one pixel around the picture
  std::vector<std::uint8_t> is_edge_;     // of a row
  std::vector<std::uint32_t> smoothed_;
  std::vector<std::uint32_t> wide_rows_[2];  // of the film, as wide as the target
  std::vector<std::uint32_t> enlarged_;
};

}  // namespace visual_node
