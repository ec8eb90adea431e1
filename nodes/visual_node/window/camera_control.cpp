#include "nodes/visual_node/window/camera_control.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {

CameraControl::CameraControl(const view::Assets& assets, const std::string& fixed_view)
    : camera_(assets.cameras.front()), fixed_view_(fixed_view) {}

CameraControl& CameraControl::Of(GLFWwindow* window) {
  return *static_cast<CameraControl*>(glfwGetWindowUserPointer(window));
}

void CameraControl::Attach(GLFWwindow* window) {
  window_ = window;
  glfwSetWindowUserPointer(window, this);
  glfwGetCursorPos(window, &last_x_, &last_y_);
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double dy) { Of(w).scroll_ += dy; });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
    if (button == GLFW_MOUSE_BUTTON_LEFT) Of(w).MouseButton(action == GLFW_PRESS);
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    if (action == GLFW_PRESS) Of(w).Key(key);
    if (action == GLFW_PRESS && key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(w, GLFW_TRUE);
  });
}

void CameraControl::Key(int key) {
  if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) wanted_view_ = key - GLFW_KEY_1;
  if (key == GLFW_KEY_0) follows_steps_ = true;
  if (keys_.size() < 16) keys_.push_back(key);
}

glm::dvec2 CameraControl::MousePixel() const {
  glm::dvec2 at(0.0);
  glm::ivec2 window(1), pixels(1);
  glfwGetCursorPos(window_, &at.x, &at.y);
  glfwGetWindowSize(window_, &window.x, &window.y);
  glfwGetFramebufferSize(window_, &pixels.x, &pixels.y);
  return at * glm::dvec2(pixels) / glm::dvec2(glm::max(window, glm::ivec2(1)));
}

void CameraControl::MouseButton(bool is_down) {
  constexpr double kStill_px = 4.0;  // a hand that clicks moves less; chosen by hand
  if (is_down) {
    pressed_px_ = MousePixel();
  } else if (pressed_px_ && !is_mouse_let_go_ && glm::distance(*pressed_px_, MousePixel()) < kStill_px) {
    click_px_ = MousePixel();
  }
}

std::vector<int> CameraControl::TakeKeys() {
  return std::exchange(keys_, {});
}

std::optional<glm::dvec2> CameraControl::TakeClick() {
  return std::exchange(click_px_, std::nullopt);
}

void CameraControl::FollowOrLeave(const view::Scene& scene, int object) {
  const scene::Camera placed = view::PlaceCamera(camera_.camera(), scene);
  camera_.Set(camera_.camera().object >= 0 ? placed : view::Follow(placed, object, scene));
  follows_steps_ = false;
}

void CameraControl::SaveView() {
  saved_.push_back(camera_.camera());
  saved_.back().name = "view_" + std::to_string(saved_.size());
}

double CameraControl::TakeScroll() {
  return std::exchange(scroll_, 0.0);
}

const scene::Camera& CameraControl::ForStep(const view::Assets& assets, const std::string& step) const {
  return view::CameraFor(assets, fixed_view_, step);
}

const scene::Camera& CameraControl::Update(const view::Assets& assets, const std::string& step, double dt_s) {
  if (window_ != nullptr) {
    constexpr double kOrbit_rad_per_px = 0.006;  // a drag over 520 px turns by 180 degrees; chosen by hand
    double x = 0.0, y = 0.0;
    glfwGetCursorPos(window_, &x, &y);
    const auto is_down = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS ? 1.0 : 0.0; };
    const double speed_m = 0.5 * dt_s;  // 0.5 m/s
    const double right = speed_m * (is_down(GLFW_KEY_D) - is_down(GLFW_KEY_A));
    const double up = speed_m * (is_down(GLFW_KEY_E) - is_down(GLFW_KEY_Q));
    const double forward = speed_m * (is_down(GLFW_KEY_W) - is_down(GLFW_KEY_S));
    const bool is_dragged = !is_mouse_let_go_ && glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
    if (is_dragged || scroll_ != 0.0 || right != 0.0 || up != 0.0 || forward != 0.0) follows_steps_ = false;
    if (is_dragged) camera_.Orbit(-kOrbit_rad_per_px * (x - last_x_), kOrbit_rad_per_px * (y - last_y_));
    if (scroll_ != 0.0) camera_.Zoom(std::pow(0.9, scroll_));
    camera_.Fly(right, up, forward);
    scroll_ = 0.0;
    last_x_ = x;
    last_y_ = y;
    const auto wanted = static_cast<std::size_t>(std::max(0, wanted_view_));
    const std::size_t num_named = assets.cameras.size();
    if (wanted_view_ >= 0 && wanted < num_named + saved_.size()) {
      camera_.Set(wanted < num_named ? assets.cameras[wanted] : saved_[wanted - num_named]);
      follows_steps_ = false;
    }
    wanted_view_ = -1;
  }
  if (follows_steps_) camera_.Set(ForStep(assets, step));
  return camera_.camera();
}

}  // namespace visual_node
