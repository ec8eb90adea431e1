#pragma once

#include <glm/glm.hpp>

namespace visual_node {

// The smallest rectangle of pixels around a far ball: x, y, width, height, from the lower left corner; empty when it is
// out of view. `clip_sky`: the clip matrix of directions; `sine`: of the ball's angular radius.
glm::ivec4 DiscRectangle(const glm::mat4& clip_sky, const glm::vec3& to_centre, float sine, int width, int height);

}  // namespace visual_node
