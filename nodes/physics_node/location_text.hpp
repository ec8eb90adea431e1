#pragma once

#include <string>

#include "scene/scenario.hpp"

namespace physics_node {

// "<file>:<line>: " before what is wrong there; empty for what no file describes.
inline std::string LocationPrefix(const scene::Location& location) {
  return location.file.empty() ? std::string() : location.file.string() + ":" + std::to_string(location.line) + ": ";
}

}  // namespace physics_node
