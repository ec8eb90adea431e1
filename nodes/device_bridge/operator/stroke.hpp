#pragma once

#include <algorithm>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

// Minimum-jerk profile from 0 to 1 over u in [0, 1], and its derivative [Flash and Hogan 1985]:
//   s = 10 u^3 - 15 u^4 + 6 u^5,   s' = 30 u^2 (1 - u)^2,   largest s' = 1.875 at u = 1/2.
constexpr double kMinimumJerkPeak = 1.875;
inline double MinimumJerk(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}
inline double MinimumJerkRate(double u) {
  if (u <= 0.0 || u >= 1.0) return 0.0;
  return 30.0 * u * u * (1.0 - u) * (1.0 - u);
}

// Duration [s] of a stroke with the given length and peak speed: T = 1.875 length / peak (m and m/s, or rad and rad/s).
inline double StrokeDuration(double length, double peak_speed) {
  return kMinimumJerkPeak * length / peak_speed;
}

// One aimed movement of a pose: straight in translation, about one axis in rotation, both minimum-jerk.
class Stroke {
 public:
  Stroke() = default;
  // `way_W` and `turn_W`: displacement and rotation vector from start to end, in W.
  Stroke(const core::Pose& start, const glm::dvec3& way_W, const glm::dvec3& turn_W, double duration_s)
      : start_(start), way_W_(way_W), turn_W_(turn_W), duration_s_(std::max(duration_s, 1e-3)), elapsed_s_(0.0) {}

  void Advance(double dt_s) { elapsed_s_ += dt_s; }
  [[nodiscard]] bool is_over() const { return elapsed_s_ >= duration_s_; }

  [[nodiscard]] core::Pose pose() const {
    const double s = MinimumJerk(elapsed_s_ / duration_s_);
    return {glm::normalize(core::QuaternionFromRotationVector(s * turn_W_) * start_.rotation),
            start_.translation + s * way_W_};
  }
  [[nodiscard]] core::Twist velocity() const {
    const double rate = MinimumJerkRate(elapsed_s_ / duration_s_) / duration_s_;
    return {rate * turn_W_, rate * way_W_};
  }

 private:
  core::Pose start_;
  glm::dvec3 way_W_{0.0};
  glm::dvec3 turn_W_{0.0};
  double duration_s_ = 1e-3;
  double elapsed_s_ = 1e-3;  // a default stroke is over
};

}  // namespace device_bridge
