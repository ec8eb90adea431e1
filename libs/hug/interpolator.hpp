#pragma once

#include <algorithm>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace hug {

// From one pose to another with least jerk: s = 10 t^3 - 15 t^4 + 6 t^5, t = time / duration, along the straight line
// and about the one axis between them [Flash, Hogan 1985].
struct Interpolator {
  core::Pose X_WA, X_WZ;
  double duration_s = 1.0;

  [[nodiscard]] core::Pose X_WI(double time_s) const {
    const double t = std::clamp(time_s / duration_s, 0.0, 1.0);
    const double s = t * t * t * (10.0 + t * (6.0 * t - 15.0));
    return {glm::normalize(core::QuaternionFromRotationVector(s * Turn()) * X_WA.rotation),
            X_WA.translation + s * (X_WZ.translation - X_WA.translation)};
  }
  [[nodiscard]] core::Twist V_WI(double time_s) const {
    const double t = std::clamp(time_s / duration_s, 0.0, 1.0);
    const double rate = 30.0 * t * t * (1.0 - t) * (1.0 - t) / duration_s;
    return {rate * Turn(), rate * (X_WZ.translation - X_WA.translation)};
  }

 private:
  [[nodiscard]] glm::dvec3 Turn() const { return core::RotationVector(X_WZ.rotation * glm::conjugate(X_WA.rotation)); }
};

}  // namespace hug
