#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "picture/image.hpp"

namespace visual_node {

// Empty when there is no such picture.
inline picture::Image ReadPng(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  return picture::ReadPng(std::as_bytes(std::span(bytes))).value_or(picture::Image());
}

}  // namespace visual_node
