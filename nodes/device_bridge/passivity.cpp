#include "nodes/device_bridge/passivity.hpp"

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"

namespace device_bridge {

core::Wrench Passivity::Step(const DeviceReading& reading, const core::Wrench& acted, bool is_in_full,
                             double others_J) noexcept {
  const core::Pose X_DD = X_WD_.inverse() * reading.X_WD;
  const glm::dvec3 way_m = reading.X_WD.translation - X_WD_.translation;
  const glm::dvec3 turn_rad = X_WD_.rotate(core::RotationVector(X_DD.rotation));
  const double work_J = glm::dot(acted.force_N, way_m) + glm::dot(acted.torque_Nm, turn_rad);
  const bool is_first = num_steps_++ == 0;
  X_WD_ = reading.X_WD;
  if (is_first || !std::isfinite(work_J)) return {};
  if (!is_in_full) {
    const core::Wrench& F = acted;
    energy_J_ = 0.5 * (glm::dot(F.force_N, F.force_N) / parameters_.stiffness_N_per_m +
                       glm::dot(F.torque_Nm, F.torque_Nm) / parameters_.stiffness_Nm_per_rad);
    return {};
  }
  energy_J_ -= work_J;
  const double E_J = energy_J_ + others_J;
  least_energy_J_ = std::min(least_energy_J_, E_J);
  if (E_J >= 0.0) return {};

  const glm::dvec3& v = reading.V_WD.linear_m_per_s;
  const glm::dvec3& w = reading.V_WD.angular_rad_per_s;
  const double twice_kinetic_J = parameters_.mass_kg * glm::dot(v, v) + parameters_.inertia_kg_m2 * glm::dot(w, w);
  if (!(twice_kinetic_J > 0.0)) return {};
  ++num_acting_;
  constexpr double kPeriod_s = static_cast<double>(core::kTick_ns) * 1e-9;
  const double a_per_s = std::min(-E_J / (kPeriod_s * twice_kinetic_J), parameters_.most_per_s);
  return {-a_per_s * parameters_.mass_kg * v, -a_per_s * parameters_.inertia_kg_m2 * w};
}

}  // namespace device_bridge
