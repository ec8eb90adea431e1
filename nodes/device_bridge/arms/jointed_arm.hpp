#pragma once

#include <vector>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "physics/chain/chain.hpp"

namespace device_bridge {

// A SIMULATED arm of seven joints under torque control, like one arm of the HUG device [Hulin et al. 2011]: lengths and
// joint limits of a light-weight robot, weight compensated, 30 % of the links' inertia left after feed-forward. The
// rotors' inertias are assumed, as none are published. Unlike a point mass, its apparent inertia depends on direction
// and posture, and its joints have limits.
class JointedArm {
 public:
  // The arm is mounted so that in its middle posture the hand frame D is at X_WD.
  explicit JointedArm(const core::Pose& X_WD);

  // Spring and damper of the hand that holds the arm, and drag of the device, all about D.
  struct Grip {
    core::Pose X_WT;  // target of the hand's spring, moving at V_WT
    core::Twist V_WT;
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
    double stiffness_Nm_per_rad = 0.0;
    double damping_Nm_s_per_rad = 0.0;
    double drag_N_s_per_m = 0.0;
    double drag_Nm_s_per_rad = 0.0;
  };
  // Integrates over dt in steps of at most 0.25 ms. The motors' wrench on D is constant; the grip is evaluated in each
  // step. No allocation.
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
  std::vector<double> motors_;  // joint torques beside the wrench: zero
};

}  // namespace device_bridge
