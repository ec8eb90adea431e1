#include "nodes/device_bridge/allowed_coupling.hpp"

#include <algorithm>

#include "core/clock.hpp"
#include "stability/sampled_axis.hpp"

namespace device_bridge {
namespace {

// A little inside the boundary, where the search for the largest damping begins.
constexpr double kInside = 0.999;

}  // namespace

AllowedCoupling ComputeAllowedCoupling(const scene::Device& device, const scene::Coupling& wanted,
                                       double delay_s) noexcept {
  constexpr double kPeriod_s = static_cast<double>(core::kTick_ns) * 1e-9;
  const stability::SampledAxis axis{device.mass_kg, device.damping_N_s_per_m, kPeriod_s, delay_s};
  const stability::SampledAxis turn{device.inertia_kg_m2, device.damping_Nm_s_per_rad, kPeriod_s, delay_s};
  AllowedCoupling allowed;
  allowed.delay_s = delay_s;
  allowed.stiffness_N_per_m = stability::MaxStiffness(axis, 0.0);
  allowed.stiffness_Nm_per_rad = stability::MaxStiffness(turn, 0.0);
  allowed.linear_stiffness_N_per_m = stability::LinearStiffnessRule(axis, 0.0);
  allowed.damping_N_s_per_m =
      stability::MaxDamping(axis, {kInside * std::min(wanted.stiffness_N_per_m, allowed.stiffness_N_per_m), 0.0});
  allowed.damping_Nm_s_per_rad =
      stability::MaxDamping(turn, {kInside * std::min(wanted.stiffness_Nm_per_rad, allowed.stiffness_Nm_per_rad), 0.0});
  return allowed;
}

}  // namespace device_bridge
