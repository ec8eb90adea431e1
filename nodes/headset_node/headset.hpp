#pragma once

#include <openxr/openxr.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "nodes/visual_node/gl/gl_objects.hpp"

struct GLFWwindow;

namespace headset_node {

constexpr std::size_t kNumEyes = 2;

// A headset, by OpenXR: where its eyes are, and the pictures that they see. All calls come from one thread, on which
// the window's OpenGL context is current.
class Headset {
 public:
  // Errors: kNotFound without a runtime or a headset, kUnsupported without OpenGL.
  static core::Result<std::unique_ptr<Headset>> Open(GLFWwindow* window);
  ~Headset();
  Headset(const Headset&) = delete;
  Headset& operator=(const Headset&) = delete;

  // Waits until the headset takes the next pictures. False: it takes none now; ask again.
  core::Result<bool> BeginFrame();
  // After BeginFrame has said true: where the eyes will be when the pictures are seen.
  [[nodiscard]] const std::array<XrView, kNumEyes>& eyes() const { return eyes_; }
  [[nodiscard]] glm::ivec2 size_px() const { return size_px_; }  // of a picture
  core::Result<void> Show(std::size_t eye, const visual_node::RenderTarget& picture);
  core::Result<void> EndFrame();

  // It was taken off for good, or its runtime has ended.
  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] const std::string& description() const { return description_; }

 private:
  struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<visual_node::GlFramebuffer> framebuffers;  // an image each
  };

  Headset() = default;
  core::Result<void> FindSystem();
  core::Result<void> BeginSession(GLFWwindow* window);
  core::Result<void> MakeSwapchains();
  core::Result<void> TakeEvents();

  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  XrSession session_ = XR_NULL_HANDLE;
  XrSpace space_ = XR_NULL_HANDLE;
  std::array<Swapchain, kNumEyes> swapchains_;
  std::array<XrView, kNumEyes> eyes_{};
  XrTime time_ = 0;
  glm::ivec2 size_px_{0};
  bool is_running_ = false;
  bool is_over_ = false;
  std::string description_;
};

}  // namespace headset_node
