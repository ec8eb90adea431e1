#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.hpp"

namespace picture {

// Eight bits each of red, green, blue, alpha; sRGB; rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 4, 0) {}

  [[nodiscard]] const std::uint8_t* Pixel(int x, int y) const {
    return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
  }
  std::uint8_t* Pixel(int x, int y) {
    return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
  }
};

// Downsamples: each pixel is the mean of factor x factor pixels (supersampling anti-aliasing of stills). Both sizes are
// multiples of the factor.
Image Shrink(const Image& image, int factor);

// Copies `from` into `to` with its top left corner at (x, y) [px]; pixels outside are clipped.
void Paste(const Image& from, int x, int y, Image& to);

// The picture in a PNG file's bytes. Error: kDamaged.
core::Result<Image> ReadPng(std::span<const std::byte> bytes);

// Creates the folder when it is missing. Error: kIo.
core::Result<void> WritePng(const Image& image, const std::filesystem::path& file);

}  // namespace picture
