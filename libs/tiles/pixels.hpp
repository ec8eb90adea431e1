#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "tiles/tile.hpp"

namespace tiles {

// A pixel's light in 32 bits: three mantissas of 9 bits with one exponent of 5, as OpenGL's RGB9_E5
// [EXT_texture_shared_exponent]. Off by 1/512 of the brightest channel at most.
std::uint32_t PackLight(const glm::vec3& light);
glm::vec3 UnpackLight(std::uint32_t packed);

// A depth along the viewing direction in 16 bits. 0: nothing is there. Else
//   1 + 65534 log(z / kNearest_m) / log(kFarthest_m / kNearest_m),
// so that it is off by 7e-5 of the depth at most, near and far.
constexpr float kNearest_m = 0.01f, kFarthest_m = 60.0f;
std::uint16_t PackDepth(float depth_m);
inline float UnpackDepth(std::uint16_t packed) {
  if (packed == 0) return 0.0f;
  static const float kSpan = std::log(kFarthest_m / kNearest_m) / 65534.0f;
  return kNearest_m * std::exp(kSpan * static_cast<float>(packed - 1));
}

// A picture as tiles bring it: light and depths, rows from the top.
struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> light;
  std::vector<std::uint16_t> depth;

  void Resize(int new_width, int new_height);
};

// The pixels of a tile for a message: where nothing is, they are only counted. Light: three floats for each pixel.
//   runs of: u16 pixels without anything, u16 pixels with something, and of those u32 light each, u16 depth each
std::string EncodePixels(const Tile& tile, std::span<const float> light, std::span<const float> depth_m);
// Into the tile's place. False, and the canvas is undefined there, when the bytes are not those of such a tile.
bool DecodePixels(const std::string& bytes, const Tile& tile, Canvas* canvas);

}  // namespace tiles
