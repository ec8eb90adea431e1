#include "nodes/visual_node/gl/gl_context.hpp"

#include <epoxy/gl.h>
// epoxy comes first, as GLFW must not include its own GL header.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cstdlib>
#include <ctime>

namespace visual_node {
namespace {

std::string LastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "no reason given";
}

// An X server that starts anew because its last client has just left, as Xvfb does, refuses clients for a moment.
bool OpenDisplay() {
  const char* display = std::getenv("DISPLAY");
  const bool has_name = display != nullptr && *display != '\0';
  const timespec pause{0, 50'000'000};
  for (int tries = has_name ? 20 : 1; tries > 0; --tries) {
    if (glfwInit() == GLFW_TRUE) return true;
    if (tries > 1) nanosleep(&pause, nullptr);
  }
  return false;
}

}  // namespace

bool IsSoftwareRenderer(const std::string& name) {
  for (const char* known : {"llvmpipe", "softpipe", "swrast", "SWR"}) {
    if (name.find(known) != std::string::npos) return true;
  }
  return false;
}

std::string RendererName() {
  return reinterpret_cast<const char*>(glGetString(GL_RENDERER));
}

double GlContext::refresh_rate_Hz() const {
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* const mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  return mode != nullptr && mode->refreshRate > 0 ? mode->refreshRate : 60.0;
}

core::Result<std::unique_ptr<GlContext>> GlContext::Create(const ContextOptions& options) {
  if (!OpenDisplay()) {
    return core::Fail(core::ErrorCode::kResource,
                      "cannot open a display: " + LastGlfwError() + "; without a screen start it under xvfb-run -a");
  }
  std::unique_ptr<GlContext> context(new GlContext);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, options.is_visible ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_DECORATED, options.is_placed ? GLFW_FALSE : GLFW_TRUE);
  context->window_ = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (context->window_ == nullptr) {
    return core::Fail(core::ErrorCode::kUnsupported, "cannot make an OpenGL 4.5 core context: " + LastGlfwError() +
                                                         "; install libgl1-mesa-dri for software rendering");
  }
  if (options.is_placed) glfwSetWindowPos(context->window_, options.x, options.y);
  glfwMakeContextCurrent(context->window_);
  glfwSwapInterval(0);  // latencies are measured without the wait for vsync
  context->renderer_name_ = RendererName();
  return context;
}

void GlContext::ToggleFullScreen() {
  auto& [x, y, width, height] = windowed_;
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, x, y, width, height, GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* const mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) return;
  glfwGetWindowPos(window_, &x, &y);
  glfwGetWindowSize(window_, &width, &height);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

GlContext::~GlContext() {
  if (is_left_) return;
  if (window_ != nullptr) glfwDestroyWindow(window_);
  glfwTerminate();
}

}  // namespace visual_node
