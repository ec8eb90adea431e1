#include "view/room.hpp"

#include <cmath>

#include "view/projection.hpp"

namespace view {

// R's axes are E's, other ways round: x_R = x_E, y_R = -z_E, z_R = y_E.
core::Pose RoomOf(const scene::Camera& placed) {
  const glm::dmat3 R_WE = glm::transpose(glm::dmat3(ViewMatrix(placed)));
  return {glm::normalize(glm::quat_cast(glm::dmat3(R_WE[0], -R_WE[2], R_WE[1]))), placed.eye_m};
}

scene::Camera CameraOf(const core::Pose& X_WR) {
  scene::Camera camera;
  camera.eye_m = X_WR.translation;
  camera.target_m = X_WR * glm::dvec3(0.0, 1.0, 0.0);
  camera.up = X_WR.rotate({0.0, 0.0, 1.0});
  return camera;
}

std::string Describe(const Head& head, const std::string& user) {
  switch (head.source) {
    case HeadSource::kNotWanted:
      return {};
    case HeadSource::kMissing:
      return "no head of " + user + " is heard: drawn for the screen's viewpoint";
    case HeadSource::kSimulated:
      return "drawn for the SIMULATED head of " + user;
    case HeadSource::kTracked:
      return "drawn for the head of " + user;
  }
  return {};
}

Screen ScreenOf(const scene::Camera& placed, double aspect) {
  const double ahead_m = glm::distance(placed.eye_m, placed.target_m);
  const double up_m = ahead_m * std::tan(0.5 * placed.vertical_fov_rad), across_m = aspect * up_m;
  return {{-across_m, ahead_m, -up_m}, {across_m, ahead_m, -up_m}, {-across_m, ahead_m, up_m}};
}

Screen Place(const core::Pose& X_WR, const Screen& screen_R) {
  return {X_WR * screen_R.lower_left, X_WR * screen_R.lower_right, X_WR * screen_R.upper_left};
}

std::array<glm::dvec3, 2> EyesOf(const core::Pose& X_RH, double eye_distance_m) {
  const glm::dvec3 half(0.5 * eye_distance_m, 0.0, 0.0);
  return {X_RH * -half, X_RH * half};
}

}  // namespace view
