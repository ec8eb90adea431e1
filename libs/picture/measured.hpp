#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"

namespace picture {

// Pixels that are measurements rather than colours for a screen: `channels` numbers each; rows from the top.
template <class T>
struct Measured {
  int width = 0, height = 0, channels = 1;
  std::vector<T> values;

  Measured() = default;
  Measured(int w, int h, int c = 1)
      : width(w),
        height(h),
        channels(c),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c)) {}

  [[nodiscard]] const T* Pixel(int x, int y) const {
    const auto index = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return &values[static_cast<std::size_t>(channels) * index];
  }
};

// One channel as a greyscale PNG of 16 bits. Creates the folder when it is missing. Error: kIo.
core::Result<void> WritePng(const Measured<std::uint16_t>& image, const std::filesystem::path& file);

// One channel (Pf) or three (PF) as a portable float map: little endian, rows from the bottom, as that format has them.
// Creates the folder when it is missing. Error: kIo.
core::Result<void> WritePfm(const Measured<float>& image, const std::filesystem::path& file);

}  // namespace picture
