#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace hug {

// The body that a hand feels under admittance control. Mass and inertia are those of the other simulated arms, so that
// scenarios feel alike with either. The damping is a free choice between a hand that coasts and one that drags: a push
// is over after m / b = 0.3 s, a turn after 0.6 s.
struct VirtualBody {
  double mass_kg = 1.5;
  double inertia_kg_m2 = 0.03;
  double damping_N_s_per_m = 5.0;
  double damping_Nm_s_per_rad = 0.05;
};

// Moves the virtual body by the measured force, and is what the arm then follows: m a + b v = F, in each axis of W.
class Admittance {
 public:
  void Reset(const core::Pose& X_WD, const core::Twist& V_WD);
  // The exact solution for a force that is constant over dt.
  void Step(double dt_s, const core::Wrench& F_Do_W, const VirtualBody& body);

  [[nodiscard]] const core::Pose& X_WD() const { return X_WD_; }
  [[nodiscard]] const core::Twist& V_WD() const { return V_WD_; }
  // Means over the latest step.
  [[nodiscard]] const core::Twist& mean_V_WD() const { return mean_V_WD_; }
  [[nodiscard]] const core::Twist& acceleration() const { return acceleration_; }

 private:
  core::Pose X_WD_;
  core::Twist V_WD_;
  core::Twist mean_V_WD_;
  core::Twist acceleration_;
};

}  // namespace hug
