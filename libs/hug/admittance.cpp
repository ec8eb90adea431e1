#include "hug/admittance.hpp"

#include <cmath>

namespace hug {
namespace {

struct Moved {
  glm::dvec3 way, velocity;
};

// With r = b / m, e = exp(-r dt): v(dt) = v e + (F / m) (1 - e) / r; way = v (1 - e) / r + (F / m) (dt - (1 - e) / r)
// / r. For r dt -> 0 both tend to those of a free body; below 1e-6 the series takes their place (error of order r dt).
Moved Move(const glm::dvec3& velocity, const glm::dvec3& force, double mass, double damping, double dt_s) {
  const glm::dvec3 a = force / mass;
  const double r = damping / mass;
  if (r * dt_s < 1e-6) return {dt_s * velocity + 0.5 * dt_s * dt_s * a, velocity + dt_s * a};
  const double gone = -std::expm1(-r * dt_s);
  return {(gone / r) * velocity + ((dt_s - gone / r) / r) * a, (1.0 - gone) * velocity + (gone / r) * a};
}

}  // namespace

void Admittance::Reset(const core::Pose& X_WD, const core::Twist& V_WD) {
  X_WD_ = X_WD;
  V_WD_ = mean_V_WD_ = V_WD;
  acceleration_ = {};
}

void Admittance::Step(double dt_s, const core::Wrench& F_Do_W, const VirtualBody& body) {
  const Moved linear = Move(V_WD_.linear_m_per_s, F_Do_W.force_N, body.mass_kg, body.damping_N_s_per_m, dt_s);
  const Moved angular =
      Move(V_WD_.angular_rad_per_s, F_Do_W.torque_Nm, body.inertia_kg_m2, body.damping_Nm_s_per_rad, dt_s);
  acceleration_ = {(angular.velocity - V_WD_.angular_rad_per_s) / dt_s,
                   (linear.velocity - V_WD_.linear_m_per_s) / dt_s};
  mean_V_WD_ = {angular.way / dt_s, linear.way / dt_s};
  X_WD_.translation += linear.way;
  X_WD_.rotation = glm::normalize(core::QuaternionFromRotationVector(angular.way) * X_WD_.rotation);
  V_WD_ = {angular.velocity, linear.velocity};
}

}  // namespace hug
