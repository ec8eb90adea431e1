#pragma once

#include <vector>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "physics/chain/chain.hpp"

namespace device_bridge {

// A SIMULATED arm of seven joints under torque control, as one of HUG's two [Hulin et al. 2011]: lengths and joint
// limits of a light-weight robot, its weight compensated, and what remains of its inertia after feed-forward (30 % of
// the links; rotors as below: assumed, nothing is published). Unlike a point mass it resists differently in every
// direction and posture, and its joints end.
class JointedArm {
 public:
  // The arm is mounted so that in its middle posture the hand frame D is at X_WD.
  explicit JointedArm(const core::Pose& X_WD);

  // Spring and damper of who holds the arm, and drag of the device, all at D.
  struct Grip {
    core::Pose X_WT;  // where the hand pulls to, moving at V_WT
    core::Twist V_WT;
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
    double stiffness_Nm_per_rad = 0.0;
    double damping_Nm_s_per_rad = 0.0;
    double drag_N_s_per_m = 0.0;
    double drag_Nm_s_per_rad = 0.0;
  };
  // Moves on by dt in steps of at most 0.25 ms; the motors' wrench on D is held, the grip follows. No allocation.
  void Advance(double dt_s, const core::Wrench& F_Do_W, const Grip& grip) noexcept;

  [[nodiscard]] const core::Pose& X_WD() const { return chain_.X_WL(kLast); }
  [[nodiscard]] core::Twist V_WD() const { return chain_.V_WL(kLast); }
  [[nodiscard]] const physics::ChainState& state() const { return state_; }
  [[nodiscard]] const physics::Chain& chain() const { return chain_; }
  [[nodiscard]] double kinetic_energy_J() { return chain_.KineticEnergy_J(state_); }

 private:
  static constexpr std::size_t kLast = 6;

  physics::Chain chain_;
  physics::ChainState state_;
  std::vector<core::Wrench> wrenches_;
  std::vector<double> motors_;  // beside the wrench: none
};

}  // namespace device_bridge
