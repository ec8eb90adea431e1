#pragma once

#include <glm/glm.hpp>

#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace view {

// What an eye sees: a pyramid with its tip in the eye. Its axis need not go through the middle of the picture. E: the
// eye's frame, x to the right and y up in the picture, looking along -z.
struct Frustum {
  glm::dvec3 eye_W{0.0};
  glm::dmat3 R_WE{1.0};
  // The picture's edges at the distance 1 from the eye: x_E of the left and right one, y_E of the bottom and top one.
  double left = -1.0;
  double right = 1.0;
  double bottom = -1.0;
  double top = 1.0;
  double focus_m = 1.0;  // distance along the view of what is looked at
};

// A flat rectangle as it is seen from its front, where `lower_left` is on the left.
struct Screen {
  glm::dvec3 lower_left{-1.0, 0.0, -1.0};
  glm::dvec3 lower_right{1.0, 0.0, -1.0};
  glm::dvec3 upper_left{-1.0, 0.0, 1.0};
};

// Error: kInvalidInput, unless both edges have a length and are at right angles (within a hundredth).
core::Result<void> CheckScreen(const Screen& screen);

// Of a camera that stands in W (PlaceCamera), in a picture of that width over height.
Frustum FrustumOf(const scene::Camera& placed, double aspect);

// The screen as a window, seen by an eye before it. An eye that is less than a centimetre before its plane, or behind
// it, sees as if it were a centimetre before it.
Frustum FrustumThrough(const Screen& screen_W, const glm::dvec3& eye_W);

// X_EW, and the perspective matrix in OpenGL's conventions: clip space z in [-w, w].
glm::dmat4 ViewMatrix(const Frustum& frustum);
glm::dmat4 ProjectionMatrix(const Frustum& frustum, double near_m, double far_m);

// Image position of a world point: x to the right and y down from the top left corner [px] (pixel centres at .5); z is
// the depth in front of the eye [m], negative behind it.
glm::dvec3 ProjectToPixel(const Frustum& frustum, int width, int height, const glm::dvec3& p_W);

// Pixels for a length of 1 at the distance 1 from the eye, across and up. They differ where pixels are not square.
glm::dvec2 FocalLengths_px(const Frustum& frustum, int width, int height);
// Where the point straight ahead of the eye is [px], from the middle of the picture, to the right and up.
glm::dvec2 AxisFromMiddle_px(const Frustum& frustum, int width, int height);

}  // namespace view
