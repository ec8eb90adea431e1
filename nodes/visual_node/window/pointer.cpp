#include "nodes/visual_node/window/pointer.hpp"

#include <algorithm>
#include <cmath>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {
namespace {

constexpr double kDeadZone = 0.15;  // of a stick that is let go

double Stick(float value) {
  const double size = std::abs(static_cast<double>(value));
  return size < kDeadZone ? 0.0 : std::copysign((size - kDeadZone) / (1.0 - kDeadZone), value);
}

}  // namespace

Pointer::Pointer(const scene::Scenario& scenario) {
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

// Left stick: right and up; right stick: turn and away; right trigger: the jaws; left shoulder: fine; A: grip; X:
// where to go next; Y: be shown it.
void Pointer::ReadGamepads(view::SteeringWish* wish) {
  has_gamepad_ = false;
  for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
    GLFWgamepadstate pad{};
    if (glfwJoystickIsGamepad(id) == GLFW_FALSE || glfwGetGamepadState(id, &pad) == GLFW_FALSE) continue;
    has_gamepad_ = true;
    const bool turns = pad.buttons[GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER] == GLFW_PRESS;
    const glm::dvec3 sticks(Stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X]), -Stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y]),
                            -Stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y]));
    if (turns) {
      wish->turn += glm::dvec3(-sticks.y, sticks.x, Stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X]));
    } else {
      wish->push += sticks;
    }
    wish->is_held = wish->is_held || sticks != glm::dvec3(0.0) || turns;
    wish->is_fine = wish->is_fine || pad.buttons[GLFW_GAMEPAD_BUTTON_LEFT_BUMPER] == GLFW_PRESS;
    wish->wants_guidance = wish->wants_guidance || pad.buttons[GLFW_GAMEPAD_BUTTON_Y] == GLFW_PRESS;
    trigger_ = std::clamp(0.5 * (pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] + 1.0), 0.0, 1.0);
    const bool is_button_down = pad.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS;
    if (is_button_down && !was_button_down_) is_closed_ = !is_closed_;
    was_button_down_ = is_button_down;
    const bool is_next_down = pad.buttons[GLFW_GAMEPAD_BUTTON_X] == GLFW_PRESS;
    if (is_next_down && !was_next_button_down_) shows_next_ = !shows_next_;
    was_next_button_down_ = is_next_down;
    return;
  }
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
  if (glfwGetWindowAttrib(window_, GLFW_FOCUSED) == GLFW_TRUE) ReadGamepads(&wish);
  ReadSpaceMouse(&wish);
  wish.closing = is_closed_ ? 1.0 : trigger_;
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
