#pragma once

#include <glm/glm.hpp>

#include "core/messages/device.hpp"
#include "scene/scenario.hpp"

namespace view {

// What a person did with mouse, keyboard, gamepad or another pointer since the last picture. Axes are those of the
// picture: right, up, and away from the eye.
struct SteeringWish {
  bool is_held = false;     // the clutch: the hand follows
  glm::dvec2 drag_px{0.0};  // right, up
  double wheel = 0.0;       // notches, away
  glm::dvec3 push{0.0};     // keys and sticks, each -1 to 1
  glm::dvec3 turn{0.0};     // about these axes, the same
  bool turns = false;       // drag and wheel turn the hand instead of moving it
  bool is_fine = false;     // small motions
  double closing = 0.0;     // of the jaws: 0 open, 1 closed
  bool wants_guidance = false;
};

// Makes the message for the hand that a person steers from a viewer: motions along the view's own axes, so that the
// hand follows the cursor wherever the camera is.
class HandSteering {
 public:
  // `camera`: placed in W; `height_px`: of the picture; `p_WD`: where the hand is; dt_s since the last call.
  const core::HandInput& Update(const SteeringWish& wish, const scene::Camera& camera, double height_px,
                                const glm::dvec3& p_WD, double dt_s);
  void Choose(std::uint8_t role) { input_.role_index = role; }
  [[nodiscard]] const core::HandInput& input() const { return input_; }

 private:
  core::HandInput input_;
};

}  // namespace view
