#include "hug/soft_limits.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace hug
