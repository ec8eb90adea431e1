#pragma once

#include <glm/glm.hpp>

#include "view/frustum.hpp"

namespace visual_node {

// What an eye sees of a view, and the size of its picture.
struct SeenView {
  view::Frustum eye;
  glm::ivec2 size_px{0};
};

}  // namespace visual_node
