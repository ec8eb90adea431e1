#include "nodes/visual_node/window/pointer.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {

Pointer::Pointer(const scene::Scenario& scenario) : force_cap_N_(scenario.force_cap_N) {
  for (const scene::Device& device : scenario.devices) palms_.push_back(device.palm);
}

void Pointer::Attach(GLFWwindow* window) {
  window_ = window;
  // A key that is pressed and let go between two pictures counts.
  glfwSetInputMode(window, GLFW_STICKY_KEYS, GLFW_TRUE);
  glfwGetCursorPos(window, &last_x_, &last_y_);
}

bool Pointer::IsDown(int key) const {
  return glfwGetKey(window_, key) == GLFW_PRESS;
}

bool Pointer::IsPressed(int key, bool* was_down) const {
  const bool is_down = IsDown(key);
  const bool is_pressed = is_down && !*was_down;
  *was_down = is_down;
  return is_pressed;
}

void Pointer::ReadMouseAndKeys(CameraControl* control, view::SteeringWish* wish) {
  double x = 0.0, y = 0.0;
  glfwGetCursorPos(window_, &x, &y);
  const bool is_dragged = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
  if (is_dragged) {
    wish->drag_px = {x - last_x_, last_y_ - y};
    wish->wheel = control->TakeScroll();
  }
  last_x_ = x;
  last_y_ = y;
  const bool is_shift = IsDown(GLFW_KEY_LEFT_SHIFT) || IsDown(GLFW_KEY_RIGHT_SHIFT);
  const bool is_control = IsDown(GLFW_KEY_LEFT_CONTROL) || IsDown(GLFW_KEY_RIGHT_CONTROL);
  const auto axis = [this](int more, int less) { return (IsDown(more) ? 1.0 : 0.0) - (IsDown(less) ? 1.0 : 0.0); };
  const glm::dvec3 keys(axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT), axis(GLFW_KEY_UP, GLFW_KEY_DOWN),
                        axis(GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_DOWN));
  // As a drag: an arrow to the right turns about the picture's upward axis.
  (is_control ? wish->turn : wish->push) = is_control ? glm::dvec3(-keys.y, keys.x, keys.z) : keys;
  wish->turns = is_control;
  wish->is_fine = is_shift;
  wish->is_held = is_dragged || keys != glm::dvec3(0.0);
  wish->wants_guidance = IsDown(GLFW_KEY_F1);
  if (IsPressed(GLFW_KEY_SPACE, &was_grip_down_)) is_closed_ = !is_closed_;
  if (IsPressed(GLFW_KEY_INSERT, &was_role_down_) && !palms_.empty()) role_ = (role_ + 1) % palms_.size();
  if (IsPressed(GLFW_KEY_F2, &was_next_down_)) shows_next_ = !shows_next_;
}

// Shakes with the force that the steered hand feels.
void Pointer::ReadGamepad(const view::Scene& shown, view::SteeringWish* wish) {
  const bool is_focused = glfwGetWindowAttrib(window_, GLFW_FOCUSED) == GLFW_TRUE;
  if (is_focused) gamepad_.Read(wish);
  if (gamepad_.TakeGrip()) is_closed_ = !is_closed_;
  if (gamepad_.TakeNext()) shows_next_ = !shows_next_;
  const double felt_N = is_focused && role_ < shown.felt_N.size() ? shown.felt_N[role_] : 0.0;
  gamepad_.Shake(felt_N / force_cap_N_, glfwGetTime());
}

// As an arrow key turns: the cap that is turned about the upward axis turns the hand about it. Left button: grip; right
// one: where to go next.
void Pointer::ReadSpaceMouse(view::SteeringWish* wish) {
  const double now_s = glfwGetTime();
  if (glfwGetWindowAttrib(window_, GLFW_FOCUSED) != GLFW_TRUE) {
    space_mouse_.Drop(now_s);
    return;
  }
  space_mouse_.Read(now_s, wish);
  if (space_mouse_.TakeLeftPresses() % 2 == 1) is_closed_ = !is_closed_;
  if (space_mouse_.TakeRightPresses() % 2 == 1) shows_next_ = !shows_next_;
}

const core::HandInput& Pointer::Update(const view::Scene& shown, const scene::Camera& camera, double dt_s,
                                       CameraControl* control) {
  view::SteeringWish wish;
  ReadMouseAndKeys(control, &wish);
  ReadGamepad(shown, &wish);
  ReadSpaceMouse(&wish);
  wish.closing = is_closed_ ? 1.0 : gamepad_.trigger();
  glm::dvec3 p_WD(0.0);
  if (role_ < palms_.size() && palms_[role_] >= 0 && static_cast<std::size_t>(palms_[role_]) < shown.instances.size()) {
    p_WD = shown.instances[static_cast<std::size_t>(palms_[role_])].X_WM.translation;
  }
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  steering_.Choose(static_cast<std::uint8_t>(role_));
  return steering_.Update(wish, view::PlaceCamera(camera, shown), height, p_WD, dt_s);
}

}  // namespace visual_node
