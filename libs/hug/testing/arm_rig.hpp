#pragma once

#include <functional>

#include "hug/arm.hpp"

namespace hug {

// An arm whose bridge sends a command each millisecond and whose hand holds the dead-man. Hands without stiffness pull
// by PushBy alone.
struct ArmRig {
  Arm arm;
  ArmCommand command;
  Hand hand;
  bool sends = true;
  std::function<void()> at_each_step;

  explicit ArmRig(ArmFigures figures, const glm::dvec3& start_m = {0.6, 0.0, 0.2}) : arm(figures) {
    const core::Pose X_WD{core::QuaternionFromRollPitchYaw({0.0, 0.0, 0.0}), start_m};
    starts = arm.Start(X_WD);
    hand.X_WT = X_WD;
    hand.holds_dead_man = true;
    arm.SetHand(hand);
    arm.Sense();
  }
  void Run(double duration_s) {
    const double end_s = arm.time_s() + duration_s - 1e-9;
    while (arm.time_s() < end_s) {
      if (num_steps++ % 3 == 0) {
        if (sends) arm.Send(command);
        arm.SetHand(hand);
      }
      if (at_each_step) at_each_step();
      arm.Move({}, 1e9);
      arm.Sense();
    }
  }
  // Until the force is there in full: a second of good link, a second of engaging.
  void Engage() { Run(2.2); }

  bool starts = false;
  std::uint64_t num_steps = 0;
};

inline HandImpedance NoHand() {
  HandImpedance none;
  none.stiffness_N_per_m = none.damping_N_s_per_m = 0.0;
  none.stiffness_Nm_per_rad = none.damping_Nm_s_per_rad = 0.0;
  return none;
}

}  // namespace hug
