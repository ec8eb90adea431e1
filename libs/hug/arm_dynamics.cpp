#include "hug/arm_dynamics.hpp"

#include "hug/linear.hpp"

namespace hug {

using physics::Cross;
using physics::Dot;
using physics::Force;
using physics::Motion;

namespace {

// Angles count with a lever of 0.1 m, so that both halves of a twist have one unit. The damping of 1 mm per rad bounds
// joint speeds where the arm is stretched, and changes nothing elsewhere (1e-5).
constexpr double kLever_m = 0.1;
constexpr double kDamping_m = 1e-3;

}  // namespace

void ArmDynamics::Place(const core::Pose& X_WB, const Joints& q, const Joints& speed) {
  origin_W_ = X_WB.translation;
  up_W_ = X_WB.rotate({0.0, 0.0, 1.0});
  core::Pose X = X_WB;
  Motion v;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const physics::ChainLink& link = model_.links[i];
    X = X * link.X_PJ * core::Pose{core::QuaternionFromRotationVector({0.0, 0.0, q[i]}), glm::dvec3(0.0)};
    X_WL_[i] = X;
    const glm::dvec3 z_W = X.rotate({0.0, 0.0, 1.0});
    S_[i] = {z_W, glm::cross(X.translation - origin_W_, z_W)};
    const Motion joint = speed[i] * S_[i];
    v = v + joint;
    v_[i] = v;
    bias_[i] = Cross(v, joint);
    const glm::dmat3 R = glm::mat3_cast(X.rotation);
    I_[i] = physics::RigidInertia(link.mass.mass_kg, X * link.mass.p_OCm_m - origin_W_,
                                  R * link.mass.I_Cm_O_kg_m2 * glm::transpose(R));
  }
  const core::Pose X_LF{glm::dquat(1, 0, 0, 0), {0.0, 0.0, kFlange_m}};
  X_WD_ = X * X_LF * model_.mount.X_FD;
}

core::Twist ArmDynamics::V_WD() const {
  const Motion& v = v_[kJoints - 1];
  return {v.angular, v.linear + glm::cross(v.angular, X_WD_.translation - origin_W_)};
}

core::Twist ArmDynamics::Column(std::size_t k) const {
  return {S_[k].angular, S_[k].linear + glm::cross(S_[k].angular, X_WD_.translation - origin_W_)};
}

Joints ArmDynamics::TorquesOf(const core::Wrench& F_Do_W) const {
  const Force F{F_Do_W.torque_Nm + glm::cross(X_WD_.translation - origin_W_, F_Do_W.force_N), F_Do_W.force_N};
  Joints torques;
  for (std::size_t k = 0; k < kJoints; ++k) torques[k] = Dot(S_[k], F);
  return torques;
}

Joints ArmDynamics::TorquesOf(std::size_t link, const glm::dvec3& p_WQ, const glm::dvec3& force_W) const {
  const Force F{glm::cross(p_WQ - origin_W_, force_W), force_W};
  Joints torques{};
  for (std::size_t k = 0; k <= link; ++k) torques[k] = Dot(S_[k], F);
  return torques;
}

// Recursive Newton-Euler [Featherstone 2008, Table 5.1], all in W about the base's origin. From the base outwards
//   a_i = a_{i-1} + v_i x S_i q'_i + S_i q''_i,   a_0 = g upwards,   f_i = I_i a_i + v_i x* I_i v_i,
// then from the tip inwards  tau_i = S_i . f_i + J_r q''_i,   f_{i-1} += f_i.
Joints ArmDynamics::InverseDynamics(const Joints& acceleration, double gravity_m_per_s2) {
  std::array<Force, kJoints> f;
  Motion a{glm::dvec3(0.0), gravity_m_per_s2 * up_W_};
  for (std::size_t i = 0; i < kJoints; ++i) {
    a = a + bias_[i] + acceleration[i] * S_[i];
    f[i] = I_[i] * a + Cross(v_[i], I_[i] * v_[i]);
  }
  Joints torques;
  for (std::size_t i = kJoints; i-- > 0;) {
    torques[i] = Dot(S_[i], f[i]) + model_.links[i].rotor_kg_m2 * acceleration[i];
    if (i > 0) f[i - 1] = f[i - 1] + f[i];
  }
  return torques;
}

Joints ArmDynamics::InertiaTimes(const Joints& acceleration) {
  std::array<Force, kJoints> f;
  Motion a;
  for (std::size_t i = 0; i < kJoints; ++i) {
    a = a + acceleration[i] * S_[i];
    f[i] = I_[i] * a;
  }
  Joints torques;
  for (std::size_t i = kJoints; i-- > 0;) {
    torques[i] = Dot(S_[i], f[i]) + model_.links[i].rotor_kg_m2 * acceleration[i];
    if (i > 0) f[i - 1] = f[i - 1] + f[i];
  }
  return torques;
}

// The spatial acceleration is that at a fixed place; the point Do, at r from the origin, has w x v_D in addition.
core::Twist ArmDynamics::BiasAcceleration() const {
  Motion a;
  for (std::size_t i = 0; i < kJoints; ++i) a = a + bias_[i];
  const core::Twist V = V_WD();
  return {a.angular, a.linear + glm::cross(a.angular, X_WD_.translation - origin_W_) +
                         glm::cross(V.angular_rad_per_s, V.linear_m_per_s)};
}

std::array<double, 6> ArmDynamics::ScaledColumn(std::size_t k) const {
  const core::Twist column = Column(k);
  std::array<double, 6> scaled;
  for (int c = 0; c < 3; ++c) {
    scaled[static_cast<std::size_t>(c)] = kLever_m * column.angular_rad_per_s[c];
    scaled[static_cast<std::size_t>(c + 3)] = column.linear_m_per_s[c];
  }
  return scaled;
}

std::array<double, 6> ArmDynamics::SolveHand(std::array<double, 6> y) const {
  Square<6> A{};
  for (std::size_t k = 0; k < kJoints; ++k) {
    const std::array<double, 6> J = ScaledColumn(k);
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = 0; c <= r; ++c) A[r][c] += J[r] * J[c];
    }
  }
  for (std::size_t r = 0; r < 6; ++r) A[r][r] += kDamping_m * kDamping_m;
  SolveSymmetric(&A, &y);
  return y;
}

// J^+ = J^T (J J^T + d^2 E)^-1.
Joints ArmDynamics::PseudoInverseTimes(const core::Twist& twist) const {
  std::array<double, 6> y;
  for (int c = 0; c < 3; ++c) {
    y[static_cast<std::size_t>(c)] = kLever_m * twist.angular_rad_per_s[c];
    y[static_cast<std::size_t>(c + 3)] = twist.linear_m_per_s[c];
  }
  y = SolveHand(y);
  Joints result{};
  for (std::size_t k = 0; k < kJoints; ++k) {
    const std::array<double, 6> J = ScaledColumn(k);
    for (std::size_t c = 0; c < 6; ++c) result[k] += J[c] * y[c];
  }
  return result;
}

core::Wrench ArmDynamics::WrenchOf(const Joints& torques) const {
  std::array<double, 6> y{};
  for (std::size_t k = 0; k < kJoints; ++k) {
    const std::array<double, 6> J = ScaledColumn(k);
    for (std::size_t c = 0; c < 6; ++c) y[c] += J[c] * torques[k];
  }
  y = SolveHand(y);
  core::Wrench F;
  for (int c = 0; c < 3; ++c) {
    F.torque_Nm[c] = kLever_m * y[static_cast<std::size_t>(c)];
    F.force_N[c] = y[static_cast<std::size_t>(c + 3)];
  }
  return F;
}

Joints ArmDynamics::NullSpaceOf(const Joints& v) const {
  core::Twist twist;
  for (std::size_t k = 0; k < kJoints; ++k) {
    const core::Twist column = Column(k);
    twist.angular_rad_per_s += v[k] * column.angular_rad_per_s;
    twist.linear_m_per_s += v[k] * column.linear_m_per_s;
  }
  return v - PseudoInverseTimes(twist);
}

std::array<std::array<double, 6>, 6> ArmDynamics::InverseApparentInertia() {
  Square<kJoints> M;
  for (std::size_t k = 0; k < kJoints; ++k) {
    Joints unit{};
    unit[k] = 1.0;
    M[k] = InertiaTimes(unit);
  }
  std::array<core::Twist, kJoints> J;
  for (std::size_t k = 0; k < kJoints; ++k) J[k] = Column(k);
  const auto entry = [&](std::size_t r, std::size_t k) {
    return r < 3 ? J[k].angular_rad_per_s[static_cast<int>(r)] : J[k].linear_m_per_s[static_cast<int>(r) - 3];
  };
  std::array<std::array<double, 6>, 6> result{};
  for (std::size_t c = 0; c < 6; ++c) {
    Square<kJoints> factor = M;
    Joints x;
    for (std::size_t k = 0; k < kJoints; ++k) x[k] = entry(c, k);
    SolveSymmetric(&factor, &x);
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t k = 0; k < kJoints; ++k) result[r][c] += entry(r, k) * x[k];
    }
  }
  return result;
}

}  // namespace hug
