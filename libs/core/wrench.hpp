#pragma once

#include <glm/glm.hpp>

namespace core {

// Spatial force F_Bo_W: force and torque about Bo, expressed in W.
struct Wrench {
  glm::dvec3 force_N{0.0};
  glm::dvec3 torque_Nm{0.0};

  Wrench& operator+=(const Wrench& other) {
    force_N += other.force_N;
    torque_Nm += other.torque_Nm;
    return *this;
  }
};

inline Wrench operator-(const Wrench& w) {
  return {-w.force_N, -w.torque_Nm};
}
inline Wrench operator+(Wrench a, const Wrench& b) {
  return a += b;
}
inline Wrench operator*(double s, const Wrench& w) {
  return {s * w.force_N, s * w.torque_Nm};
}

// Scales force and torque by min(1, cap / |f|), which keeps the wrench's axis.
inline Wrench LimitForce(const Wrench& F, double cap_N) {
  const double force_N = glm::length(F.force_N);
  return force_N > cap_N ? (cap_N / force_N) * F : F;
}

// Moves the point about which the torque is taken: F_Q from F_P, with p_QP the vector from Q to P in the same frame.
inline Wrench ShiftWrench(const Wrench& F_P, const glm::dvec3& p_QP) {
  return {F_P.force_N, F_P.torque_Nm + glm::cross(p_QP, F_P.force_N)};
}

// Spatial velocity V_WBo: angular velocity of B and linear velocity of Bo in W, expressed in W.
struct Twist {
  glm::dvec3 angular_rad_per_s{0.0};
  glm::dvec3 linear_m_per_s{0.0};
};

// Velocity of a point fixed in B, with p_BoQ_W the vector from Bo to the point, expressed in W.
inline glm::dvec3 PointVelocity(const Twist& V_WB, const glm::dvec3& p_BoQ_W) {
  return V_WB.linear_m_per_s + glm::cross(V_WB.angular_rad_per_s, p_BoQ_W);
}

}  // namespace core
