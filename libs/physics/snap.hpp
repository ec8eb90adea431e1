#pragma once

#include "physics/row.hpp"
#include "physics/snap_profile.hpp"

namespace physics {

// scene::Mechanism of kind snap. J_child's origin is pulled to J_parent's; z of J_parent points out of the socket.
struct SnapParams {
  core::Pose X_PJ;
  core::Pose X_CJ;
  double engage_force_N = 0.0;
  double release_force_N = 0.0;
  double travel_m = 0.003;
  SnapProfile profile;  // of pushing in, with engage_force_N as its largest force; none: half a sine over travel_m
  double guide_length_m = 0.0;
  double lateral_tolerance_m = 0.001;
  double tilt_tolerance_rad = 0.035;
  double stiffness_N_per_m = 2.0e4;
  double stiffness_Nm_per_rad = 40.0;
  double damping_N_s_per_m = 30.0;
  bool is_initially_engaged = false;
};

// Axial force of the snap on the child at z above the seat, out of the socket positive, and its slope.
//
// Two wells with hysteresis. Engaged: F = -k z, until k z reaches the release force at z_r = F_r / k. Free: a bump
// that resists pushing in, F = F_e sin(pi (travel - z) / (travel - z_e)) for z_e < z < travel, peak F_e, nothing
// beyond; it engages at z_e = min(z_r / 2, travel / 4). With a profile: F_e times that, from its first point on, and
// z_e = min(z_r / 2, its first point).
// A cycle never gains energy: engaging costs B(z_e) = int_{z_e}^{travel} F and returns k z_e^2 / 2; releasing costs
// k z_r^2 / 2 and returns at most B(z_r) <= B(z_e) as z_r >= z_e. So the balance is >= k (z_r^2 - z_e^2) / 2 >= 0.
struct SnapForce {
  double force_N = 0.0;
  double stiffness_N_per_m = 0.0;  // max(0, -dF/dz)
};
SnapForce SnapAxialForce(const SnapParams& params, bool is_engaged, double z_m);
// Its potential, -F = dV/dz: k z^2 / 2 engaged, B(z) free.
double SnapAxialEnergy_J(const SnapParams& params, bool is_engaged, double z_m);
double SnapReleasePoint_m(const SnapParams& params);  // z_r
double SnapEngagePoint_m(const SnapParams& params);   // z_e

// Work of the axial force on the child from z = a to z = b in one go, with the changes of state on the way.
double SnapWork_J(const SnapParams& params, double a_m, double b_m, bool* is_engaged);

// The axial force has the work of the profile, whatever the speed. A step is symplectic: the speed v is known half a
// step before the place z, so that a = z - dt v / 2 and b = z + dt v' / 2 are the places that belong to the speeds v
// and v' before and after the step, and a force's work on the child is F dt (v + v') / 2 = F (b - a). With
//   F = work of the profile from a to b / (b - a)
// kinetic energy plus the profile's is kept (discrete gradient, Gonzalez 1996). b is that of the speed at the start,
// with F's slope along dt v' / 4 where the profile stabilises; what this differs from the way that the part then took
// stays in a ledger and is paid with the next steps.
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
  // Where the child is in J_parent.
  struct Place {
    core::Pose X_WJp;
    core::Pose X_WJc;
    glm::dvec3 offset_m{0.0};
    glm::dvec3 turn_rad{0.0};
  };
  [[nodiscard]] Place PlaceOf(const BodyView& parent, const BodyView& child) const;
  // Share of the guide's springs at z.
  [[nodiscard]] double Hold(double z_m) const;
  void Take(const Place& place, double a_m, double v_m_per_s);
  void SetAxial(const glm::dvec3& axis_W, const glm::dvec3& p_W, double z_m, double v_m_per_s, double dt_s);

  SnapParams params_;
  bool is_guided_ = false;

  // Of the last step.
  bool has_acted_ = false;
  double a_m_ = 0.0;
  double v_m_per_s_ = 0.0;  // at its start
  double acted_damping_N_s_per_m_ = 0.0;
  SnapParams acted_params_;
  double ledger_J_ = 0.0;  // given to the child beyond the profile's work
};

}  // namespace physics
