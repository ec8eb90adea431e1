#include "view/conformance/cast_ids.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "view/projection.hpp"

namespace view {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// How far along the ray o + t d (in the body's frame) it meets the ball: |o + t d| = r.
double MeetBall(const glm::dvec3& o, const glm::dvec3& d, double radius_m) {
  const double b = glm::dot(o, d), c = glm::dot(o, o) - radius_m * radius_m, a = glm::dot(d, d);
  const double root = b * b - a * c;
  if (root < 0.0) return kNever;
  const double t = (-b - std::sqrt(root)) / a;
  return t > 0.0 ? t : kNever;
}

// It meets the box where it has entered all three slabs and left none.
double MeetBox(const glm::dvec3& o, const glm::dvec3& d, const glm::dvec3& half_m) {
  double enter = 0.0, leave = kNever;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0.0) {
      if (std::abs(o[k]) > half_m[k]) return kNever;
      continue;
    }
    const double t0 = (-half_m[k] - o[k]) / d[k], t1 = (half_m[k] - o[k]) / d[k];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter > 0.0 && enter <= leave ? enter : kNever;
}

}  // namespace

std::vector<KnownBody> KnownBodies() {
  const auto turned = [](double angle_rad, const glm::dvec3& axis, const glm::dvec3& p_W) {
    return core::Pose{glm::angleAxis(angle_rad, glm::normalize(axis)), p_W};
  };
  return {{false, {1.6, 1.2, 0.02}, turned(0.0, {0, 0, 1}, {0, 0, -0.01})},
          {true, {0.2, 0.2, 0.2}, turned(0.0, {0, 0, 1}, {-0.25, 0.0, 0.1})},
          {false, {0.2, 0.1, 0.3}, turned(0.7, {1, 2, 3}, {0.2, 0.1, 0.2})},
          {true, {0.06, 0.06, 0.06}, turned(0.0, {0, 0, 1}, {0.12, -0.3, 0.12})},
          {false, {0.02, 0.02, 0.5}, turned(0.4, {0, 1, 0}, {-0.1, -0.2, 0.2})}};
}

scene::Camera KnownCamera() {
  scene::Camera camera;
  camera.eye_m = {0.3, -1.2, 0.7};
  camera.target_m = {0.0, 0.0, 0.1};
  camera.vertical_fov_rad = 0.7;
  return camera;
}

picture::Measured<std::uint16_t> CastIds(const std::vector<KnownBody>& bodies, const scene::Camera& camera, int width,
                                         int height) {
  const glm::dmat3 R_WE = glm::transpose(glm::dmat3(ViewMatrix(camera)));
  const double focal_px = 0.5 * height / std::tan(0.5 * camera.vertical_fov_rad);
  picture::Measured<std::uint16_t> ids(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 d_W = R_WE * glm::dvec3(x + 0.5 - 0.5 * width, 0.5 * height - y - 0.5, -focal_px);
      double nearest = kNever;
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        const core::Pose X_OW = bodies[i].X_WO.inverse();
        const glm::dvec3 o = X_OW * camera.eye_m, d = X_OW.rotate(d_W);
        const double t =
            bodies[i].is_ball ? MeetBall(o, d, 0.5 * bodies[i].size_m.x) : MeetBox(o, d, 0.5 * bodies[i].size_m);
        if (t >= nearest) continue;
        nearest = t;
        ids.values[static_cast<std::size_t>(y * width + x)] = static_cast<std::uint16_t>(i + 1);
      }
    }
  }
  return ids;
}

}  // namespace view
