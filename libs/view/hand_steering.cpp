#include "view/hand_steering.hpp"

#include <algorithm>
#include <cmath>

#include "view/projection.hpp"

namespace view {
namespace {

// Chosen by hand. A wrist turns by 90 degrees over 300 px.
constexpr double kTurn_rad_per_px = 0.005;
constexpr double kNotch_m = 0.01;
constexpr double kNotch_rad = 0.1;
constexpr double kPush_m_per_s = 0.15;
constexpr double kTurn_rad_per_s = 0.8;
constexpr double kFineShare = 0.2;
constexpr double kNearestHand_m = 0.02;  // a hand at the eye or behind it moves as one there

}  // namespace

// With the view's axes r, u and f (right, up, forward), depth d of the hand and picture height h [px], a pixel at the
// hand is 2 d tan(fov / 2) / h wide. Dragging to the right turns the hand about u, upwards about -r: what faces the eye
// goes with the cursor.
const core::HandInput& HandSteering::Update(const SteeringWish& wish, const scene::Camera& camera, double height_px,
                                            const glm::dvec3& p_WD, double dt_s) {
  const glm::dmat3 R_WE = glm::transpose(glm::dmat3(ViewMatrix(camera)));
  const glm::dvec3 right = R_WE[0], up = R_WE[1], forward = -R_WE[2];
  const double depth_m = std::max(kNearestHand_m, glm::dot(p_WD - camera.eye_m, forward));
  const double pixel_m = 2.0 * depth_m * std::tan(0.5 * camera.vertical_fov_rad) / std::max(1.0, height_px);
  const double share = wish.is_fine ? kFineShare : 1.0;
  input_.is_held = wish.is_held;
  input_.closing = wish.closing;
  input_.wants_guidance = wish.wants_guidance;
  if (!wish.is_held) return input_;
  glm::dvec3 way = kPush_m_per_s * dt_s * wish.push;  // along right, up, forward
  glm::dvec3 turn = kTurn_rad_per_s * dt_s * wish.turn;
  if (wish.turns) {
    turn += glm::dvec3(-kTurn_rad_per_px * wish.drag_px.y, kTurn_rad_per_px * wish.drag_px.x, kNotch_rad * wish.wheel);
  } else {
    way += glm::dvec3(pixel_m * wish.drag_px.x, pixel_m * wish.drag_px.y, kNotch_m * wish.wheel);
  }
  input_.moved_W_m += share * (way.x * right + way.y * up + way.z * forward);
  input_.turned_W_rad += share * (turn.x * right + turn.y * up + turn.z * forward);
  return input_;
}

}  // namespace view
