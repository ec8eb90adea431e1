#include "view/projection.hpp"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace view {

// Where the view direction is nearly z (acos 0.999), the two do not span a plane.
glm::dvec3 UpFor(const glm::dvec3& forward) {
  return std::abs(glm::normalize(forward).z) > 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
}

glm::dmat4 ViewMatrix(const scene::Camera& camera) {
  const bool has_up = camera.up != glm::dvec3(0.0);
  return glm::lookAt(camera.eye_m, camera.target_m, has_up ? camera.up : UpFor(camera.target_m - camera.eye_m));
}

glm::dmat4 ProjectionMatrix(double vertical_fov_rad, double aspect, double near_m, double far_m) {
  return glm::perspective(vertical_fov_rad, aspect, near_m, far_m);
}

glm::dvec3 ProjectToPixel(const scene::Camera& camera, int width, int height, const glm::dvec3& p_W) {
  const glm::dvec3 p_E(ViewMatrix(camera) * glm::dvec4(p_W, 1.0));
  // Pinhole camera with focal length f [px]: f tan(fov / 2) = height / 2, and x_px = width / 2 + f x_E / depth,
  // y_px = height / 2 - f y_E / depth.
  const double focal_px = 0.5 * height / std::tan(0.5 * camera.vertical_fov_rad);
  const double depth_m = -p_E.z;
  return {0.5 * width + focal_px * p_E.x / depth_m, 0.5 * height - focal_px * p_E.y / depth_m, depth_m};
}

// The light's eye stands 2 r from the centre, so the sphere lies between the depths r and 3 r.
glm::dmat4 SunMatrix(const glm::dvec3& sun_direction_W, const glm::dvec3& centre_W, double radius_m) {
  const glm::dvec3 towards = glm::normalize(sun_direction_W);
  const glm::dmat4 view = glm::lookAt(centre_W + 2.0 * radius_m * towards, centre_W, UpFor(towards));
  return glm::ortho(-radius_m, radius_m, -radius_m, radius_m, radius_m, 3.0 * radius_m) * view;
}

}  // namespace view
