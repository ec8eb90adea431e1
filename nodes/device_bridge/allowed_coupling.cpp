#include "nodes/device_bridge/allowed_coupling.hpp"

#include <algorithm>

#include "core/clock.hpp"
#include "stability/modes.hpp"

namespace device_bridge {
namespace {

constexpr double kPeriod_s = static_cast<double>(core::kTick_ns) * 1e-9;

// A little inside the boundary, where the search for the largest damping begins.
constexpr double kInside = 0.999;

stability::Matrix6 Isotropic(double translation, double rotation) noexcept {
  stability::Matrix6 A{};
  for (std::size_t i = 0; i < 6; ++i) A[i][i] = i < 3 ? translation : rotation;
  return A;
}

// The coupling about the device's frame. A motion (x, phi) of the device moves the point r where the coupling acts by
// x + phi x r = x - [r] phi, with [r] a = r x a. The energy k |x - [r] phi|^2 / 2 + k_t |phi|^2 / 2 has the stiffness
//   K = ( k I       -k [r]              )
//       ( k [r]     k_t I - k [r] [r]   ),   as [r]^T = -[r].
stability::Matrix6 StiffnessAt(const scene::Coupling& coupling, const glm::dvec3& r) noexcept {
  const double k = coupling.stiffness_N_per_m;
  const double cross[3][3] = {{0.0, -r.z, r.y}, {r.z, 0.0, -r.x}, {-r.y, r.x, 0.0}};
  stability::Matrix6 K = Isotropic(k, coupling.stiffness_Nm_per_rad);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      K[i][3 + j] = -k * cross[i][j];
      K[3 + i][j] = k * cross[i][j];
      for (std::size_t l = 0; l < 3; ++l) K[3 + i][3 + j] -= k * cross[i][l] * cross[l][j];
    }
  }
  return K;
}

}  // namespace

stability::SampledAxis DeviceAxis(const scene::Device& device, double delay_s) noexcept {
  return {device.mass_kg, device.damping_N_s_per_m, kPeriod_s, delay_s};
}

AllowedCoupling ComputeAllowedCoupling(const scene::Device& device, const scene::Coupling& wanted,
                                       const glm::dvec3& p_DoCm_D, double delay_s) noexcept {
  const stability::SampledAxis axis = DeviceAxis(device, delay_s);
  const stability::SampledAxis turn{device.inertia_kg_m2, device.damping_Nm_s_per_rad, kPeriod_s, delay_s};
  const stability::SampledBody body{Isotropic(axis.mass_kg, turn.mass_kg),
                                    Isotropic(axis.damping_N_s_per_m, turn.damping_N_s_per_m), kPeriod_s, delay_s};
  AllowedCoupling allowed;
  allowed.delay_s = delay_s;
  allowed.share = stability::LargestStableShare(body, StiffnessAt(wanted, p_DoCm_D), stability::Matrix6{});
  allowed.stiffness_N_per_m = stability::MaxStiffness(axis, 0.0);
  allowed.stiffness_Nm_per_rad = stability::MaxStiffness(turn, 0.0);
  allowed.linear_stiffness_N_per_m = stability::LinearStiffnessRule(axis, 0.0);
  const double used = kInside * std::min(1.0, allowed.share);
  // The damper of the translations acts at r, where the device is lightest across it: 1/m' = 1/m + r^2/I.
  stability::SampledAxis at_tool = axis;
  at_tool.mass_kg = 1.0 / (1.0 / axis.mass_kg + glm::dot(p_DoCm_D, p_DoCm_D) / turn.mass_kg);
  allowed.damping_N_s_per_m = stability::MaxDamping(at_tool, {used * wanted.stiffness_N_per_m, 0.0});
  allowed.damping_Nm_s_per_rad = stability::MaxDamping(turn, {used * wanted.stiffness_Nm_per_rad, 0.0});
  return allowed;
}

}  // namespace device_bridge
