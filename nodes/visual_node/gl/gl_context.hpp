#pragma once

#include <memory>
#include <string>

#include "core/result.hpp"

struct GLFWwindow;

namespace visual_node {

struct ContextOptions {
  int width = 640;
  int height = 360;
  std::string title = "VR-OOS";
  bool is_placed = false;  // at x, y of the display, without a frame
  int x = 0;
  int y = 0;
  bool is_visible = true;  // false: pictures only; still needs an X display, such as Xvfb
};

// Whether OpenGL's name of a renderer is one of Mesa's that have no graphics card.
bool IsSoftwareRenderer(const std::string& name);
// Of the current context.
std::string RendererName();

// A window and its OpenGL 4.5 core context, current on the calling thread. One per process.
class GlContext {
 public:
  // Errors: kResource without a display, kUnsupported without OpenGL 4.5.
  static core::Result<std::unique_ptr<GlContext>> Create(const ContextOptions& options);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Does not close the window on destruction; the end of the process closes it.
  void LeaveToKernel() { is_left_ = true; }

  // Between the window and the whole screen.
  void ToggleFullScreen();

  [[nodiscard]] GLFWwindow* window() const { return window_; }
  [[nodiscard]] const std::string& renderer_name() const { return renderer_name_; }  // e.g. "llvmpipe (LLVM 15 ...)"
  [[nodiscard]] bool is_software() const { return IsSoftwareRenderer(renderer_name_); }
  // Of the screen: pictures per second. 60 when it does not say.
  [[nodiscard]] double refresh_rate_Hz() const;

 private:
  GlContext() = default;
  GLFWwindow* window_ = nullptr;
  bool is_left_ = false;
  int windowed_[4] = {0, 0, 0, 0};  // place and size of the window while it fills the screen
  std::string renderer_name_;
};

}  // namespace visual_node
