#pragma once

#include <memory>

#include "nodes/visual_node/gl/gl_objects.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {

// As large as the window's pixels; nothing changes while they are too few to see anything.
inline void FitTo(GLFWwindow* window, std::unique_ptr<RenderTarget>* target) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  if (width < 16 || height < 16 || (width == (*target)->width() && height == (*target)->height())) return;
  *target = std::make_unique<RenderTarget>(width, height);
}

}  // namespace visual_node
