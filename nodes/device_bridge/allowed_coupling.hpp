#pragma once

#include "scene/scenario.hpp"

namespace device_bridge {

// Stiffness and damping that can be rendered on a hand device, by the exact boundary of libs/stability, each axis by
// itself. For the device alone: a hand that holds it adds damping.
struct AllowedCoupling {
  double delay_s = 0.0;            // what it was computed for
  double stiffness_N_per_m = 0.0;  // without rendered damping, as the virtual coupling is
  double stiffness_Nm_per_rad = 0.0;
  double linear_stiffness_N_per_m = 0.0;  // by the linear rule, for display
  double damping_N_s_per_m = 0.0;         // largest with the smaller of wanted and allowed stiffness
  double damping_Nm_s_per_rad = 0.0;
};

// Real-time: no allocation; some 10 us at a delay of a few periods.
AllowedCoupling ComputeAllowedCoupling(const scene::Device& device, const scene::Coupling& wanted,
                                       double delay_s) noexcept;

}  // namespace device_bridge
