#pragma once

#include "physics/row.hpp"
#include "physics/snap_profile.hpp"

namespace physics {

// scene::Mechanism of kind snap: pulls J_child's origin to J_parent's; z of J_parent points out of the socket.
struct SnapParams {
  core::Pose X_PJ;
  core::Pose X_CJ;
  double engage_force_N = 0.0;
  double release_force_N = 0.0;
  double travel_m = 0.003;
  SnapProfile profile;  // of insertion, scaled by engage_force_N; none: half a sine over travel_m
  double guide_length_m = 0.0;
  double lateral_tolerance_m = 0.001;
  double tilt_tolerance_rad = 0.035;
  double stiffness_N_per_m = 2.0e4;
  double stiffness_Nm_per_rad = 40.0;
  double damping_N_s_per_m = 30.0;
  bool is_initially_engaged = false;
};

// Axial force [N] of the snap on the child at z [m] above the seat, positive out of the socket, and its slope.
//
// Two wells with hysteresis. Engaged: F = -k z, until k z reaches the release force at z_r = F_r / k. Free: a barrier
// against insertion, F = F_e sin(pi (travel - z) / (travel - z_e)) for z_e < z < travel, zero elsewhere; it engages at
// z_e = min(z_r / 2, travel / 4). With a profile: F_e times the profile, and z_e = min(z_r / 2, its first point).
//
// A cycle never gains energy: engaging takes B(z_e) = int_{z_e}^{travel} F dz and returns k z_e^2 / 2; releasing takes
// k z_r^2 / 2 and returns at most B(z_r) <= B(z_e), as z_r >= z_e. So a cycle takes at least k (z_r^2 - z_e^2) / 2 >=
// 0.
struct SnapForce {
  double force_N = 0.0;
  double stiffness_N_per_m = 0.0;  // max(0, -dF/dz)
};
SnapForce SnapAxialForce(const SnapParams& params, bool is_engaged, double z_m);
// Its potential V [J], -F = dV/dz: k z^2 / 2 when engaged, B(z) when free.
double SnapAxialEnergy_J(const SnapParams& params, bool is_engaged, double z_m);
double SnapReleasePoint_m(const SnapParams& params);  // z_r
double SnapEngagePoint_m(const SnapParams& params);   // z_e

// Work [J] of the axial force on the child on a monotonic way from z = a to z = b, with the changes of state on the
// way.
double SnapWork_J(const SnapParams& params, double a_m, double b_m, bool* is_engaged);

// The axial force does exactly the work of the profile at any speed. A step is symplectic: the speed v is half a step
// earlier than the place z, so a = z - dt v / 2 and b = z + dt v' / 2 are the places that belong to the speeds v and v'
// before and after the step, and the work of a force on the child is F dt (v + v') / 2 = F (b - a). With
//   F = (work of the profile from a to b) / (b - a)
// kinetic plus potential energy is conserved (discrete gradient) [Gonzalez 1996]. b is predicted from the speed at the
// start, with the slope of F by v' where the profile is stable. The difference between this work and that on the actual
// way is kept in a ledger and compensated in the next steps.
//
// Tunables: engage_force_N, release_force_N, stiffness_N_per_m, stiffness_Nm_per_rad, damping.
class Snap final : public Mechanism {
 public:
  explicit Snap(const SnapParams& params);
  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  [[nodiscard]] double StoredEnergy_J(const BodyView& parent, const BodyView& child) const override;
  void ExchangeState(Checkpoint* checkpoint) override;

  [[nodiscard]] bool is_engaged() const { return state_ == 1; }
  [[nodiscard]] bool is_guided() const { return is_guided_; }

 private:
  // Pose of the child in J_parent.
  struct Place {
    core::Pose X_WJp;
    core::Pose X_WJc;
    glm::dvec3 offset_m{0.0};
    glm::dvec3 turn_rad{0.0};
  };
  [[nodiscard]] Place PlaceOf(const BodyView& parent, const BodyView& child) const;
  // Share of the guide's full stiffness at z, 0 to 1.
  [[nodiscard]] double Hold(double z_m) const;
  void UpdateState(const Place& place, double a_m, double v_m_per_s);
  void SetAxial(const glm::dvec3& axis_W, const glm::dvec3& p_W, double z_m, double v_m_per_s, double dt_s);

  SnapParams params_;
  bool is_guided_ = false;

  // Of the last step.
  bool has_acted_ = false;
  double a_m_ = 0.0;
  double v_m_per_s_ = 0.0;  // at its start
  double acted_damping_N_s_per_m_ = 0.0;
  SnapParams acted_params_;
  double ledger_J_ = 0.0;  // work on the child in excess of the profile's
};

}  // namespace physics
