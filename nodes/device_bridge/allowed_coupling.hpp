#pragma once

#include <glm/glm.hpp>

#include "scene/scenario.hpp"
#include "stability/sampled_axis.hpp"

namespace device_bridge {

// Stiffness and damping that can be rendered on a hand device, by the exact boundary of libs/stability. For the device
// alone: a hand that holds it adds damping.
struct AllowedCoupling {
  double delay_s = 0.0;  // what it was computed for
  // Of the wanted stiffness in translation and rotation together, by the modes of M^-1 K, without rendered damping.
  double share = 0.0;
  double stiffness_N_per_m = 0.0;  // each axis by itself, for display
  double stiffness_Nm_per_rad = 0.0;
  double linear_stiffness_N_per_m = 0.0;  // by the linear rule, for display
  double damping_N_s_per_m = 0.0;         // largest with the smaller of wanted and allowed stiffness
  double damping_Nm_s_per_rad = 0.0;
};

// A translation of the device, sampled and driven by the bridge.
stability::SampledAxis DeviceAxis(const scene::Device& device, double delay_s) noexcept;

// `p_DoCm_D`: where the coupling acts, the tool's centre of mass, from the device's frame. Real-time: no allocation;
// some 30 us at a delay of a few periods.
AllowedCoupling ComputeAllowedCoupling(const scene::Device& device, const scene::Coupling& wanted,
                                       const glm::dvec3& p_DoCm_D, double delay_s) noexcept;

}  // namespace device_bridge
