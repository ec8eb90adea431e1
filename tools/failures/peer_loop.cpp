#include "tools/failures/peer_loop.hpp"

#include <cmath>

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;
// K T^2 / m of the explicit spring with critical damping, B T / m = 2 sqrt(0.1): a fifth of what is stable.
constexpr double kExplicit = 0.1;
constexpr double kLeast = kTick_s * kTick_s / kExplicit;  // mass over stiffness

}  // namespace

void PeerLoop::AddTool(const vps::TriangleMesh& mesh, const core::Pose& X_WD) {
  AddBall(mesh, X_WD, coupling_.stiffness_N_per_m * kLeast, coupling_.stiffness_Nm_per_rad * kLeast);
  X_WD_before_ = X_WD;
}

void PeerLoop::Tick(const core::Pose& X_WD) {
  const core::Pose X_WT = X_WC();
  const core::Twist V_WT = V_WC();
  const glm::dvec3 v_D = (X_WD.translation - X_WD_before_.translation) / kTick_s;
  const glm::dvec3 w_D = core::RotationVector(X_WD.rotation * glm::conjugate(X_WD_before_.rotation)) / kTick_s;
  const glm::dvec3 turn = core::RotationVector(X_WD.rotation * glm::conjugate(X_WT.rotation));
  const double T_critical_s = 2.0 * std::sqrt(kLeast);  // damping over stiffness
  const core::Wrench F_W{
      coupling_.stiffness_N_per_m * (X_WD.translation - X_WT.translation + T_critical_s * (v_D - V_WT.linear_m_per_s)),
      coupling_.stiffness_Nm_per_rad * (turn + T_critical_s * (w_D - V_WT.angular_rad_per_s))};
  Push(F_W);
  command_ = -F_W;
  X_WD_before_ = X_WD;
  Tick();
}

void PeerLoop::LetGo(const core::Pose& X_WD) {
  PutAtRest(X_WD);
  X_WD_before_ = X_WD;
}

}  // namespace failures
