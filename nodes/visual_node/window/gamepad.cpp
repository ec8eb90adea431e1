#include "nodes/visual_node/window/gamepad.hpp"

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

void Gamepad::Read(view::SteeringWish* wish) {
  is_there_ = false;
  GLFWgamepadstate pad{};
  int id = GLFW_JOYSTICK_1;
  while (id <= GLFW_JOYSTICK_LAST &&
         (glfwJoystickIsGamepad(id) == GLFW_FALSE || glfwGetGamepadState(id, &pad) == GLFW_FALSE))
    ++id;
  if (id > GLFW_JOYSTICK_LAST) {
    trigger_ = 0.0;
    rumble_.Choose("", "");
    return;
  }
  is_there_ = true;
  const auto is_down = [&pad](int button) { return pad.buttons[button] == GLFW_PRESS; };
  const bool turns = is_down(GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER);
  const glm::dvec3 sticks(Stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X]), -Stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y]),
                          -Stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y]));
  if (turns) {
    wish->turn += glm::dvec3(-sticks.y, sticks.x, Stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X]));
  } else {
    wish->push += sticks;
  }
  wish->is_held = wish->is_held || sticks != glm::dvec3(0.0) || turns;
  wish->is_fine = wish->is_fine || is_down(GLFW_GAMEPAD_BUTTON_LEFT_BUMPER);
  wish->wants_guidance = wish->wants_guidance || is_down(GLFW_GAMEPAD_BUTTON_Y);
  trigger_ = std::clamp(0.5 * (pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] + 1.0), 0.0, 1.0);
  grip_.Put(is_down(GLFW_GAMEPAD_BUTTON_A));
  next_.Put(is_down(GLFW_GAMEPAD_BUTTON_X));
  rumble_.Choose(glfwGetJoystickName(id), glfwGetJoystickGUID(id));
}

}  // namespace visual_node
