#include "core/pose.hpp"

#include <gtest/gtest.h>

#include "core/wrench.hpp"

namespace core {
namespace {

const Pose kX_AB{QuaternionFromRotationVector({0.3, -0.8, 1.1}), {0.1, -2.0, 0.5}};
const Pose kX_BC{QuaternionFromRotationVector({-1.0, 0.2, 0.4}), {1.0, 0.0, -0.3}};

TEST(Pose, ComposesByAdjacency) {
  const glm::dvec3 p_CQ(0.2, 0.7, -0.4);
  EXPECT_LT(glm::length((kX_AB * kX_BC) * p_CQ - kX_AB * (kX_BC * p_CQ)), 1e-15);
}

TEST(Pose, InverseTimesPoseIsIdentity) {
  const glm::dvec3 p_BQ(0.2, 0.7, -0.4);
  EXPECT_LT(glm::length(kX_AB.inverse() * (kX_AB * p_BQ) - p_BQ), 1e-15);
}

TEST(RotationVector, IsInverseOfQuaternionFromRotationVector) {
  for (const double angle : {0.0, 1e-14, 1e-6, 0.5, 3.1}) {
    const glm::dvec3 phi = angle * glm::normalize(glm::dvec3(1, -2, 0.5));
    EXPECT_LT(glm::length(RotationVector(QuaternionFromRotationVector(phi)) - phi), 1e-14) << angle;
  }
}

TEST(QuaternionFromRollPitchYaw, TurnsAboutFixedAxesInOrder) {
  const double right_angle = glm::radians(90.0);
  const glm::dvec3 v = QuaternionFromRollPitchYaw({right_angle, 0, right_angle}) * glm::dvec3(0, 1, 0);
  EXPECT_LT(glm::length(v - glm::dvec3(0, 0, 1)), 1e-15);  // roll takes y to z, yaw leaves z
}

TEST(ShiftWrench, KeepsPowerOfARigidMotion) {
  const Wrench F_P{{1, 2, 3}, {-0.1, 0.4, 0.2}};
  const glm::dvec3 p_QP(0.3, -0.2, 0.9);
  const Twist V_Q{{0.5, -1, 2}, {0.1, 0.2, 0.3}};
  const Wrench F_Q = ShiftWrench(F_P, p_QP);
  const double power_at_Q = glm::dot(F_Q.force_N, V_Q.linear_m_per_s) + glm::dot(F_Q.torque_Nm, V_Q.angular_rad_per_s);
  const double power_at_P =
      glm::dot(F_P.force_N, PointVelocity(V_Q, p_QP)) + glm::dot(F_P.torque_Nm, V_Q.angular_rad_per_s);
  EXPECT_NEAR(power_at_Q, power_at_P, 1e-15);
}

}  // namespace
}  // namespace core
