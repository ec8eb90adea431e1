#pragma once

#include <glm/glm.hpp>

#include "scene/scenario.hpp"

namespace view {

// Matrices of a camera in OpenGL's conventions: eye frame E looks along -z with y up; clip space z in [-w, w].
// Up is world z, or world y when the camera looks straight along z.
glm::dmat4 ViewMatrix(const scene::Camera& camera);
glm::dmat4 ProjectionMatrix(double vertical_fov_rad, double aspect, double near_m, double far_m);

// Where a world point appears: x to the right, y DOWN from the top left corner, in pixels (pixel centres at .5);
// z is the depth in front of the eye [m], negative behind it.
glm::dvec3 ProjectToPixel(const scene::Camera& camera, int width, int height, const glm::dvec3& p_W);

// View of a box of the world from the sun: an orthographic clip matrix that just holds the sphere (centre, radius).
glm::dmat4 SunMatrix(const glm::dvec3& sun_direction_W, const glm::dvec3& centre_W, double radius_m);

}  // namespace view
