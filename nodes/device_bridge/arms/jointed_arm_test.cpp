#include "nodes/device_bridge/arms/jointed_arm.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace device_bridge {
namespace {

JointedArm::Grip Hand(const core::Pose& X_WT) {
  JointedArm::Grip grip;
  grip.X_WT = X_WT;
  grip.stiffness_N_per_m = 800.0;
  grip.damping_N_s_per_m = 60.0;
  grip.stiffness_Nm_per_rad = 25.0;
  grip.damping_Nm_s_per_rad = 1.2;
  return grip;
}

const core::Pose kStart{core::QuaternionFromRollPitchYaw({0.3, -0.2, 1.0}), {0.1, -0.3, 0.4}};

TEST(JointedArm, StartsAtTheGivenPoseAndStaysThere) {
  JointedArm arm(kStart);
  EXPECT_LT(glm::length(arm.X_WD().translation - kStart.translation), 1e-12);
  EXPECT_LT(glm::length(core::RotationVector(arm.X_WD().rotation * glm::conjugate(kStart.rotation))), 1e-12);
  for (int i = 0; i < 1000; ++i) arm.Advance(1e-3, {}, Hand(kStart));
  EXPECT_LT(glm::length(arm.X_WD().translation - kStart.translation), 1e-9);
}

TEST(JointedArm, ComesToRestWhereTheHandsSpringBalancesTheMotors) {
  JointedArm arm(kStart);
  const core::Wrench push{{5.0, -3.0, 8.0}, {0.1, 0.2, -0.1}};
  for (int i = 0; i < 5000; ++i) arm.Advance(1e-3, push, Hand(kStart));
  EXPECT_LT(glm::length(arm.X_WD().translation - kStart.translation - push.force_N / 800.0), 1e-7);
  const glm::dvec3 turn = core::RotationVector(arm.X_WD().rotation * glm::conjugate(kStart.rotation));
  EXPECT_LT(glm::length(turn - push.torque_Nm / 25.0), 1e-7);
}

TEST(JointedArm, FollowsAMovingHandWithoutDelayWhenItsTargetMovesSteadily) {
  JointedArm arm(kStart);
  JointedArm::Grip grip = Hand(kStart);
  grip.V_WT.linear_m_per_s = {0.05, 0.02, -0.03};
  for (int i = 0; i < 2000; ++i) {
    arm.Advance(1e-3, {}, grip);
    grip.X_WT.translation += 1e-3 * grip.V_WT.linear_m_per_s;
  }
  // What remains is the arm's own friction.
  EXPECT_LT(glm::length(arm.X_WD().translation - grip.X_WT.translation), 2e-3);
}

TEST(JointedArm, ApparentMassDependsOnTheDirection) {
  // That of a point mass does not.
  double least = 1e9;
  double most = 0.0;
  for (int i = 0; i < 3; ++i) {
    JointedArm arm(kStart);
    core::Wrench push;
    push.force_N[i] = 1.0;
    for (int k = 0; k < 5; ++k) arm.Advance(1e-3, push, {});
    const double mass_kg = 5e-3 / glm::length(arm.V_WD().linear_m_per_s);
    least = std::min(least, mass_kg);
    most = std::max(most, mass_kg);
  }
  EXPECT_GT(least, 0.3);
  EXPECT_LT(most, 10.0);
  EXPECT_GT(most, 1.2 * least);
}

TEST(JointedArm, StaysWithinItsJointLimitsUnderLargeForces) {
  JointedArm arm(kStart);
  core::Pose away = kStart;
  away.translation += glm::dvec3(3.0, 0.5, -0.4);
  for (int i = 0; i < 4000; ++i) {
    arm.Advance(1e-3, {}, Hand(away));
    ASSERT_TRUE(std::isfinite(arm.X_WD().translation.x));
    for (std::size_t k = 0; k < arm.chain().num_joints(); ++k) {
      ASSERT_LE(arm.state().position[k], arm.chain().link(k).upper);
      ASSERT_GE(arm.state().position[k], arm.chain().link(k).lower);
    }
  }
  EXPECT_LT(arm.kinetic_energy_J(), 0.5);
}

TEST(JointedArm, GainsLessThanFivePercentEnergyWithoutDamping) {
  JointedArm arm(kStart);
  JointedArm::Grip grip = Hand(kStart);
  grip.damping_N_s_per_m = 0.0;
  grip.damping_Nm_s_per_rad = 0.0;
  grip.X_WT.translation.x += 0.05;
  const double stored_J = 0.5 * 800.0 * 0.05 * 0.05;
  double largest = 0.0;
  for (int i = 0; i < 5000; ++i) {
    arm.Advance(1e-3, {}, grip);
    const glm::dvec3 off = arm.X_WD().translation - grip.X_WT.translation;
    const glm::dvec3 turn = core::RotationVector(arm.X_WD().rotation * glm::conjugate(grip.X_WT.rotation));
    largest = std::max(largest, arm.kinetic_energy_J() + 400.0 * glm::dot(off, off) + 12.5 * glm::dot(turn, turn));
  }
  EXPECT_LT(largest, 1.05 * stored_J);  // a spring force held over a step of 0.25 ms is late by half of the step
}

}  // namespace
}  // namespace device_bridge
