#pragma once

#include <glm/glm.hpp>

#include "scene/scenario.hpp"

namespace view {

// Upwards in a picture that looks along `forward`: z, or y within 2.6 degrees of z.
glm::dvec3 UpFor(const glm::dvec3& forward);

// The view matrix X_EW and the perspective matrix of a camera in OpenGL's conventions: eye frame E looks along -z with
// y up; clip space z in [-w, w]. Up is the camera's, or UpFor in W.
glm::dmat4 ViewMatrix(const scene::Camera& camera);
glm::dmat4 ProjectionMatrix(double vertical_fov_rad, double aspect, double near_m, double far_m);

// Image position of a world point: x to the right and y down from the top left corner [px] (pixel centres at .5); z is
// the depth in front of the eye [m], negative behind it.
glm::dvec3 ProjectToPixel(const scene::Camera& camera, int width, int height, const glm::dvec3& p_W);

// Orthographic clip matrix of the shadow map: the view from the sun of the sphere (centre, radius). `sun_direction_W`
// points towards the sun and need not be of unit length.
glm::dmat4 SunMatrix(const glm::dvec3& sun_direction_W, const glm::dvec3& centre_W, double radius_m);

}  // namespace view
