#include "hug/soft_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "hug/testing/arm_rig.hpp"

namespace hug {
namespace {

TEST(SoftLimits, DoNothingInTheReadyPosture) {
  ArmDynamics arm(LightWeightRobot({}));
  arm.Place({}, arm.model().ready, {});
  bool is_touched = true;
  const Joints torques = LimitTorques({}, arm, arm.model().ready, {}, &is_touched);
  EXPECT_FALSE(is_touched);
  for (const double torque : torques) EXPECT_EQ(torque, 0.0);
}

TEST(SoftLimits, HoldSixtyThreeNewtonMetresAtAJointsLimit) {
  ArmDynamics arm(LightWeightRobot({}));
  Joints q = arm.model().ready;
  q[0] = -arm.model().limit[0];
  arm.Place({}, q, {});
  bool is_touched = false;
  EXPECT_NEAR(LimitTorques({}, arm, q, {}, &is_touched)[0], 63.0, 1e-9);
  EXPECT_TRUE(is_touched);
}

// A hand that pulls with all that a clutch holds, in six directions: no joint reaches its end stop, the arm is not
// stretched out, and nothing swings.
TEST(SoftLimits, KeepAnArmInsideWhicheverWayAHandPulls) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      ArmFigures figures;
      ArmRig rig(figures);
      rig.Engage();
      glm::dvec3 way(0.0);
      way[axis] = side;
      double most_m = 0.0, nearest = 1.0;
      rig.at_each_step = [&] {
        // The hand pulls at up to 60 N: its target runs 75 mm ahead, within a box of a metre.
        const glm::dvec3 there = rig.arm.X_WD().translation + 0.075 * way;
        rig.hand.X_WT.translation += std::min(1.0, 0.001 / (1e-9 + glm::distance(there, rig.hand.X_WT.translation))) *
                                     (there - rig.hand.X_WT.translation) * 0.3;
        const ArmDynamics& arm = rig.arm.measured();
        most_m = std::max(most_m, glm::distance(arm.X_WL(5).translation, arm.X_WL(1).translation));
        for (std::size_t i = 0; i < kJoints; ++i) {
          nearest = std::min(nearest, arm.model().limit[i] - std::abs(rig.arm.truth().position[i]));
        }
      };
      rig.Run(3.0);
      EXPECT_GT(nearest, 0.0) << axis << " " << side;
      EXPECT_LT(most_m, 0.789) << axis;
      EXPECT_TRUE(rig.arm.status().is_at_limit) << axis << " " << side;
      EXPECT_LT(glm::length(rig.arm.V_WD().linear_m_per_s), 0.1) << axis << " " << side;
    }
  }
}

// A hand that comes at a speed, and then pulls with what simulated operators do at most, 34 N. The arm stops it before
// its end stops, by less than a clutch holds; and neither the knock at the start nor the one at the limit is taken for
// a fault of a sensor.
TEST(SoftLimits, StopAHandThatComesFast) {
  for (const ControlMode mode : {ControlMode::kImpedance, ControlMode::kAdmittance}) {
    for (const double speed_m_per_s : {0.4, 0.7, 1.0}) {
      for (int way = 0; way < 6; ++way) {
        ArmFigures figures;
        figures.control.mode = mode;
        ArmRig rig(figures);
        rig.Engage();
        glm::dvec3 out(0.0);
        out[way / 2] = way % 2 == 0 ? -1.0 : 1.0;
        double most_m = 0.0, nearest = 1.0, most_N = 0.0;
        rig.at_each_step = [&] {
          const bool goes = glm::dot(rig.hand.X_WT.translation - rig.arm.X_WD().translation, out) < 34.0 / 800.0;
          rig.hand.V_WT.linear_m_per_s = goes ? speed_m_per_s * out : glm::dvec3(0.0);
          rig.hand.X_WT.translation += Arm::kStep_s * rig.hand.V_WT.linear_m_per_s;
          const ArmDynamics& arm = rig.arm.measured();
          most_m = std::max(most_m, glm::distance(arm.X_WL(5).translation, arm.X_WL(1).translation));
          most_N = std::max(most_N, glm::length(rig.arm.hand_F_Do_W().force_N));
          for (std::size_t i = 0; i < kJoints; ++i) {
            nearest = std::min(nearest, arm.model().limit[i] - std::abs(rig.arm.truth().position[i]));
          }
        };
        rig.Run(3.0);
        const std::string what = std::to_string(static_cast<int>(mode)) + " at " + std::to_string(speed_m_per_s) +
                                 " m/s, way " + std::to_string(way);
        EXPECT_EQ(rig.arm.safety().state(), SafetyState::kForce)
            << what << ": " << NameOf(rig.arm.safety().first_cause());
        EXPECT_TRUE(rig.arm.status().is_at_limit) << what;
        EXPECT_LT(most_N, figures.clutch.holds_N) << what;
        EXPECT_LT(most_m, 0.789) << what;
        EXPECT_GT(nearest, 0.0) << what;
        EXPECT_LT(glm::length(rig.arm.V_WD().linear_m_per_s), 0.05) << what;
      }
    }
  }
}

// v = sqrt(2 a left): at 1 m/s and 62.5 mm before the margin, 8 m/s2 stop it there. So nothing pushes from further off,
// and closer by the damper of what is too fast.
TEST(SoftLimits, LetAHandComeAsFastAsItCanBeStopped) {
  ArmDynamics arm(LightWeightRobot({}));
  const SoftLimits limits;
  const auto pull_N = [&](double left_m, double out_m_per_s) {
    // Elbow such that shoulder and wrist are that far apart: d^2 = a^2 + b^2 + 2 a b cos q.
    constexpr double a = 0.4, b = 0.39;
    const double d = limits.stretch_m - left_m;
    Joints q = arm.model().ready, speed{};
    q[3] = std::acos((d * d - a * a - b * b) / (2.0 * a * b));
    const double slope_m = -a * b * std::sin(q[3]) / d;  // of d over q
    speed[3] = out_m_per_s / slope_m;
    arm.Place({}, q, speed);
    bool is_touched = false;
    const double torque_Nm = LimitTorques(limits, arm, q, speed, &is_touched)[3];
    EXPECT_EQ(is_touched, torque_Nm != 0.0);
    return -torque_Nm / slope_m;
  };
  EXPECT_EQ(pull_N(0.0626, 1.0), 0.0);
  EXPECT_NEAR(pull_N(0.0625, 1.1), 0.1 * limits.stretch_damping_N_s_per_m, 1e-6);
  EXPECT_EQ(pull_N(0.03, -0.5), 0.0) << "it comes back";
  EXPECT_NEAR(pull_N(-0.002, 0.1), 60.0 + 35.0, 1e-6);
  EXPECT_NEAR(pull_N(-0.002, -0.1), 60.0, 1e-6);
}

}  // namespace
}  // namespace hug
