#include "view/frustum.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "view/projection.hpp"

namespace view {
namespace {

constexpr double kNearPlane_m = 0.01;  // as near as a renderer's near plane

}  // namespace

core::Result<void> CheckScreen(const Screen& screen) {
  const glm::dvec3 across = screen.lower_right - screen.lower_left, up = screen.upper_left - screen.lower_left;
  const double product = glm::length(across) * glm::length(up);
  if (product > 0.0 && std::abs(glm::dot(across, up)) <= 0.01 * product) return {};
  return core::Fail(core::ErrorCode::kInvalidInput,
                    "the screen's corners are no rectangle: from the lower left corner, the lower right and the upper "
                    "left one are in directions at right angles");
}

Frustum FrustumOf(const scene::Camera& placed, double aspect) {
  const double up = std::tan(0.5 * placed.vertical_fov_rad), across = aspect * up;
  return {placed.eye_m, glm::transpose(glm::dmat3(ViewMatrix(placed))), -across, across, -up,
          up,           glm::distance(placed.eye_m, placed.target_m)};
}

// Generalised perspective [Kooima 2009]. E's axes are the screen's: x along its lower edge, y up along its left one, z
// towards the eye. With the corner a from the eye, the screen's plane is at the distance d = -a.z, and the corner's
// place at the distance 1 is (a.x, a.y) / d.
Frustum FrustumThrough(const Screen& screen_W, const glm::dvec3& eye_W) {
  const glm::dvec3 across = screen_W.lower_right - screen_W.lower_left, up = screen_W.upper_left - screen_W.lower_left;
  const glm::dvec3 x = glm::normalize(across), z = glm::normalize(glm::cross(across, up)), y = glm::cross(z, x);
  const glm::dvec3 corner_W = screen_W.lower_left - eye_W;
  const double d_m = std::max(kNearPlane_m, -glm::dot(corner_W, z));
  const double left = glm::dot(corner_W, x) / d_m, bottom = glm::dot(corner_W, y) / d_m;
  return {eye_W, glm::dmat3(x, y, z), left, left + glm::length(across) / d_m, bottom, bottom + glm::dot(up, y) / d_m,
          d_m};
}

glm::dmat4 ViewMatrix(const Frustum& frustum) {
  const glm::dmat3 R_EW = glm::transpose(frustum.R_WE);
  glm::dmat4 X_EW(R_EW);
  X_EW[3] = glm::dvec4(-(R_EW * frustum.eye_W), 1.0);
  return X_EW;
}

glm::dmat4 ProjectionMatrix(const Frustum& frustum, double near_m, double far_m) {
  return glm::frustum(near_m * frustum.left, near_m * frustum.right, near_m * frustum.bottom, near_m * frustum.top,
                      near_m, far_m);
}

glm::dvec3 ProjectToPixel(const Frustum& frustum, int width, int height, const glm::dvec3& p_W) {
  const glm::dvec3 p_E = glm::transpose(frustum.R_WE) * (p_W - frustum.eye_W);
  const double depth_m = -p_E.z;
  return {width * (p_E.x / depth_m - frustum.left) / (frustum.right - frustum.left),
          height * (frustum.top - p_E.y / depth_m) / (frustum.top - frustum.bottom), depth_m};
}

glm::dvec2 FocalLengths_px(const Frustum& frustum, int width, int height) {
  return {width / (frustum.right - frustum.left), height / (frustum.top - frustum.bottom)};
}

glm::dvec2 AxisFromMiddle_px(const Frustum& frustum, int width, int height) {
  return -0.5 * FocalLengths_px(frustum, width, height) *
         glm::dvec2(frustum.left + frustum.right, frustum.bottom + frustum.top);
}

}  // namespace view
