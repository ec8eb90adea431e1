#pragma once

#include "physics/row.hpp"

namespace physics {

// scene::Mechanism of kind hinge. J_parent and J_child coincide at angle 0; rotation about z of J.
struct HingeParams {
  core::Pose X_PJ;
  core::Pose X_CJ;
  double lower_rad = -3.14159;
  double upper_rad = 3.14159;
  bool has_detents = false;
  double detents_rad[2] = {0.0, 0.0};  // ascending
  double detent_torque_Nm = 0.0;
  double damping_Nm_s_per_rad = 0.0;
  bool is_stuck = false;  // cannot be turned
};

// Torque of a two-position detent at angle theta, on the child: -peak sin(2 pi u), u = (theta - d0) / (d1 - d0).
// Zero at both detents (stable) and half way (unstable), pulling to the nearer one in between, at most `peak`.
// Beyond a detent it goes on to a quarter period, where it peaks, and stays there.
double DetentTorque(double theta_rad, double d0_rad, double d1_rad, double peak_Nm);

// Pose of the child's mesh frame in the parent's at a given angle.
core::Pose HingePose(const HingeParams& params, double angle_rad);

class Hinge final : public Mechanism {
 public:
  explicit Hinge(const HingeParams& params);
  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  void ExchangeState(Checkpoint* checkpoint) override;

  void set_detent_torque_Nm(double value) { params_.detent_torque_Nm = value; }

 private:
  HingeParams params_;
  bool has_lock_angle_ = false;
  double lock_angle_rad_ = 0.0;
};

}  // namespace physics
