#include "view/free_camera.hpp"

#include <algorithm>
#include <cmath>

namespace view {

// In spherical coordinates about the target T, with distance d, azimuth a and elevation e [rad]:
//   p_TE = d (cos e cos a, cos e sin a, sin e).
void FreeCamera::Orbit(double azimuth_rad, double elevation_rad) {
  constexpr double kMaxElevation_rad = 1.5533;  // 89 degrees: at 90 the view's up direction is undefined
  const glm::dvec3 p_TE = camera_.eye_m - camera_.target_m;
  const double distance_m = glm::length(p_TE);
  if (distance_m <= 0.0) return;
  const double azimuth = std::atan2(p_TE.y, p_TE.x) + azimuth_rad;
  const double elevation = std::clamp(std::asin(std::clamp(p_TE.z / distance_m, -1.0, 1.0)) + elevation_rad,
                                      -kMaxElevation_rad, kMaxElevation_rad);
  camera_.eye_m =
      camera_.target_m + distance_m * glm::dvec3(std::cos(elevation) * std::cos(azimuth),
                                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
}

void FreeCamera::Zoom(double factor) {
  const glm::dvec3 p_TE = camera_.eye_m - camera_.target_m;
  const double distance_m = glm::length(p_TE);
  if (distance_m <= 0.0) return;
  camera_.eye_m = camera_.target_m + std::max(0.01, distance_m * factor) / distance_m * p_TE;
}

void FreeCamera::Fly(double right_m, double up_m, double forward_m) {
  const glm::dvec3 forward = glm::normalize(camera_.target_m - camera_.eye_m);
  const glm::dvec3 side = glm::cross(forward, glm::dvec3(0, 0, 1));
  const glm::dvec3 right = glm::length(side) > 1e-6 ? glm::normalize(side) : glm::dvec3(1, 0, 0);
  const glm::dvec3 shift = right_m * right + up_m * glm::cross(right, forward) + forward_m * forward;
  camera_.eye_m += shift;
  camera_.target_m += shift;
}

}  // namespace view
