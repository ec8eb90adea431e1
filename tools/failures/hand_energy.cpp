#include "tools/failures/hand_energy.hpp"

#include <algorithm>

#include "core/clock.hpp"

namespace failures {
namespace {

constexpr double kTick_s = 1e-9 * static_cast<double>(core::kTick_ns);
constexpr double kNoForce_N = 1e-6;

double MeanSquare(const glm::dvec3& a, const glm::dvec3& b) {  // of a vector that goes straight from a to b
  return (glm::dot(a, a) + glm::dot(a, b) + glm::dot(b, b)) / 3.0;
}

}  // namespace

void HandEnergy::Add(const core::DeviceState& device, const core::Wrench& acted, const scene::Device& parameters) {
  if (has_begun_) {
    const glm::dvec3 way_m = device.X_WD.translation - X_WD_.translation;
    const glm::dvec3 turn_rad = core::RotationVector(device.X_WD.rotation * glm::conjugate(X_WD_.rotation));
    const double put_in_J = -glm::dot(acted.force_N, way_m) - glm::dot(acted.torque_Nm, turn_rad);
    energy_J_ += put_in_J;
    least_J_ = std::min(least_J_, energy_J_);
    const double taken_W =
        parameters.damping_N_s_per_m * MeanSquare(device.V_WD.linear_m_per_s, V_WD_.linear_m_per_s) +
        parameters.damping_Nm_s_per_rad * MeanSquare(device.V_WD.angular_rad_per_s, V_WD_.angular_rad_per_s);
    with_damping_J_ += put_in_J + kTick_s * taken_W;
  }
  if (glm::length(acted.force_N) < kNoForce_N && glm::length(acted.torque_Nm) < kNoForce_N) {
    least_of_windows_J_ = std::min(least_of_windows_J_, with_damping_J_ - most_J_);
    most_J_ = std::max(most_J_, with_damping_J_);
  }
  has_begun_ = true;
  X_WD_ = device.X_WD;
  V_WD_ = device.V_WD;
}

}  // namespace failures
