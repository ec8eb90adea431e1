#pragma once

#include <png.h>

#include <filesystem>

#include "picture/image.hpp"

namespace visual_node {

// Empty when there is no such picture.
inline picture::Image ReadPng(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, file.c_str()) == 0) return {};
  png.format = PNG_FORMAT_RGBA;
  picture::Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr);
  return image;
}

}  // namespace visual_node
