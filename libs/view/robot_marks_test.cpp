#include "view/robot_marks.hpp"

#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

namespace view {
namespace {

core::DeviceJoints TwoJoints() {
  core::DeviceJoints robot;
  robot.is_simulated = true;
  robot.state = 4;
  robot.X_WD.translation = {0.0, 0.0, 0.6};
  for (int i = 0; i < 2; ++i) {
    core::DeviceJoint joint;
    joint.X_WL.translation = {0.0, 0.0, 0.3 * i};
    joint.radius_m = 0.05f;
    joint.position_rad = 0.5f;
    joint.measured_Nm = 3.0f;
    joint.commanded_Nm = 3.0f;
    joint.temperature_degC = 31.0f;
    robot.joints.push_back(joint);
  }
  return robot;
}

TEST(RobotMarks, AnArcTurnsTheWayOfTheMeasuredTorqueBeyondTheCommand) {
  core::DeviceJoints robot = TwoJoints();
  Scene scene;
  AddRobot(robot, &scene);
  EXPECT_TRUE(scene.rings.empty()) << "measured as commanded";
  robot.joints[1].measured_Nm = 13.0f;
  AddRobot(robot, &scene);
  ASSERT_EQ(scene.rings.size(), 1u);
  EXPECT_NEAR(scene.rings[0].sweep_rad, 0.5 * glm::pi<double>(), 1e-6);
  EXPECT_EQ(scene.rings[0].axis_W, glm::dvec3(0, 0, 1));
  EXPECT_EQ(scene.rings[0].p_WCentre, robot.joints[1].X_WL.translation);
  robot.joints[1].measured_Nm = -7.0f;
  AddRobot(robot, &scene);
  EXPECT_EQ(scene.rings[1].axis_W, glm::dvec3(0, 0, -1));
}

TEST(RobotMarks, ABillboardHasTheJointsFiguresAndTheHandTheState) {
  Scene scene;
  core::DeviceJoints robot = TwoJoints();
  robot.state = 7;
  robot.first_cause = 5;
  AddRobot(robot, &scene);
  ASSERT_EQ(scene.labels.size(), 3u);
  EXPECT_EQ(scene.labels[0].text, "1: 28.6 deg  3.0 Nm  31 degC");
  EXPECT_EQ(scene.labels[2].text, "SIMULATED  FAULT: clutch");
}

TEST(RobotMarks, AGreenPhantomStandsWhereTheInterpolatorWantsTheRobot) {
  core::DeviceJoints robot = TwoJoints();
  Scene scene;
  AddRobot(robot, &scene);
  EXPECT_EQ(scene.spheres.size(), 1u);
  robot.has_target = true;
  robot.X_WD_target.translation = {1.0, 0.0, 0.6};
  for (int i = 0; i < 2; ++i) {
    robot.joints[static_cast<std::size_t>(i)].X_WL_target.translation = {1.0, 0.0, 0.3 * i};
  }
  AddRobot(robot, &scene);
  ASSERT_EQ(scene.spheres.size(), 3u);
  EXPECT_GT(scene.spheres[2].color.g, scene.spheres[2].color.r);
  for (const glm::vec4& bead : *scene.spheres[2].p_P_radius_m) EXPECT_EQ(bead.x, 1.0f);
}

}  // namespace
}  // namespace view
