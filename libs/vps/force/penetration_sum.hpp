#pragma once

#include <glm/glm.hpp>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace vps {

// Sum over colliding points of V(P_i) n_i and of P_i x V(P_i) n_i [VR-OOS, Eq. 1]. The paper calls these force and
// torque, but they are a length [m] and a length squared [m^2]; newtons appear only with a stiffness (Eq. 6).
struct PenetrationSum {
  glm::dvec3 sum_m{0.0};
  glm::dvec3 moment_m2{0.0};  // about the point that the holder names

  PenetrationSum& operator+=(const PenetrationSum& other) {
    sum_m += other.sum_m;
    moment_m2 += other.moment_m2;
    return *this;
  }
};

inline PenetrationSum operator-(const PenetrationSum& f) {
  return {-f.sum_m, -f.moment_m2};
}
inline PenetrationSum operator*(double s, const PenetrationSum& f) {
  return {s * f.sum_m, s * f.moment_m2};
}

// The same sum expressed in A instead of B (only turned: the moment stays about the same point).
inline PenetrationSum Rotate(const core::Pose& X_AB, const PenetrationSum& f_B) {
  return {X_AB.rotate(f_B.sum_m), X_AB.rotate(f_B.moment_m2)};
}

// Moves the point about which the moment is taken: about Q from about P, p_QP from Q to P, all in one frame.
inline PenetrationSum Shift(const PenetrationSum& f_P, const glm::dvec3& p_QP) {
  return {f_P.sum_m, f_P.moment_m2 + glm::cross(p_QP, f_P.sum_m)};
}

// Penalty wrench of a contact of stiffness k [N/m].
inline core::Wrench PenaltyWrench(double stiffness_N_per_m, const PenetrationSum& f) {
  return {stiffness_N_per_m * f.sum_m, stiffness_N_per_m * f.moment_m2};
}

}  // namespace vps
