#pragma once

#include "physics/joint_axis.hpp"

namespace physics {

// scene::Mechanism of kind hinge. J_parent and J_child coincide at angle 0; rotation about z of J.
struct HingeParams {
  core::Pose X_PJ;
  core::Pose X_CJ;
  JointAxisParams axis;  // rad, Nm; the angle is within (-pi, pi], so limits beyond that have no effect
  bool has_detents = false;
  double detents_rad[2] = {0.0, 0.0};  // ascending
  double detent_torque_Nm = 0.0;
};

// Torque [Nm] of a two-position detent on the child: T = -peak sin(2 pi u), u = (theta - d0) / (d1 - d0). It is zero at
// both detents (stable) and half way (unstable), and acts towards the nearer detent. Beyond a quarter period outside of
// a detent it stays at the peak.
double DetentTorque(double theta_rad, double d0_rad, double d1_rad, double peak_Nm);
// Its potential [J], zero at the detents: V = peak (d1 - d0) (1 - cos(2 pi u)) / (2 pi), linear beyond a quarter
// period.
double DetentEnergy_J(double theta_rad, double d0_rad, double d1_rad, double peak_Nm);

// Pose of the child's mesh frame in the parent's at a given angle.
core::Pose HingePose(const HingeParams& params, double angle_rad);

// Tunables: damping, detent_torque_Nm, locked, motor_rad_per_s, motor_torque_Nm.
class Hinge final : public Mechanism {
 public:
  explicit Hinge(const HingeParams& params);
  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  [[nodiscard]] double StoredEnergy_J(const BodyView& parent, const BodyView& child) const override;
  void ExchangeState(Checkpoint* checkpoint) override;
  // Between steps: where the servo turns the child to, within the limits.
  void SetServoTarget(double angle_rad);

 private:
  std::span<Row> axis_rows() { return std::span(rows()).subspan(kFirstAxisRow, JointAxis::kNumRows); }

  static constexpr std::size_t kFirstAxisRow = 5;
  HingeParams params_;
  JointAxis axis_;
};

}  // namespace physics
