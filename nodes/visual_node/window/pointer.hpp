#pragma once

#include <vector>

#include "nodes/visual_node/window/camera_control.hpp"
#include "nodes/visual_node/window/gamepad.hpp"
#include "nodes/visual_node/window/space_mouse.hpp"
#include "scene/scenario.hpp"
#include "view/hand_steering.hpp"
#include "view/scene.hpp"
#include "view/steering_caption.hpp"

struct GLFWwindow;

namespace visual_node {

// A person steers a simulated arm's hand from this window: right mouse button, arrow keys, a gamepad or
// a SpaceMouse.
class Pointer {
 public:
  explicit Pointer(const scene::Scenario& scenario);

  // After CameraControl::Attach.
  void Attach(GLFWwindow* window);
  // Before CameraControl::Update, from which it takes the wheel while the hand is held. `shown` and `camera`: of the
  // last picture. The message to send.
  const core::HandInput& Update(const view::Scene& shown, const scene::Camera& camera, double dt_s,
                                CameraControl* control);
  // What the last picture's lines say about it (view::DescribeSteering).
  [[nodiscard]] view::SteeringState state() const {
    return {.input = steering_.input(),
            .has_gamepad = gamepad_.is_there(),
            .has_space_mouse = space_mouse_.is_there(),
            .shows_next = shows_next_};
  }

 private:
  void ReadMouseAndKeys(CameraControl* control, view::SteeringWish* wish);
  void ReadGamepad(const view::Scene& shown, view::SteeringWish* wish);
  void ReadSpaceMouse(view::SteeringWish* wish);
  [[nodiscard]] bool IsDown(int key) const;
  // True once for each press.
  bool IsPressed(int key, bool* was_down) const;

  GLFWwindow* window_ = nullptr;
  std::vector<int> palms_;  // object of each role
  view::HandSteering steering_;
  std::size_t role_ = 0;
  bool is_closed_ = false;  // by the space bar
  bool was_grip_down_ = false, was_role_down_ = false, was_next_down_ = false;
  bool shows_next_ = false;
  double last_x_ = 0.0, last_y_ = 0.0;
  double force_cap_N_;
  Gamepad gamepad_;
  SpaceMouse space_mouse_;
};

}  // namespace visual_node
