#pragma once

#include <memory>
#include <vector>

#include "view/overlay_shapes.hpp"

namespace visual_node {

inline view::SharedPoints Share(const std::vector<glm::vec3>& points) {
  return std::make_shared<const std::vector<glm::vec3>>(points);
}

}  // namespace visual_node
