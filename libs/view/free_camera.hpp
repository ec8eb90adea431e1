#pragma once

#include "scene/scenario.hpp"

namespace view {

// A camera that a person steers: orbit and zoom about the target, or translate eye and target together. Independent of
// any window.
class FreeCamera {
 public:
  explicit FreeCamera(const scene::Camera& start) : camera_(start) {}

  void Set(const scene::Camera& camera) { camera_ = camera; }
  // Turns the eye about the target: azimuth about world z, elevation limited to 89 degrees. Distance is kept.
  void Orbit(double azimuth_rad, double elevation_rad);
  // Multiplies the distance between eye and target; never below 1 cm.
  void Zoom(double factor);
  // Moves eye and target along the view's own axes [m].
  void Fly(double right_m, double up_m, double forward_m);

  [[nodiscard]] const scene::Camera& camera() const { return camera_; }

 private:
  scene::Camera camera_;
};

}  // namespace view
