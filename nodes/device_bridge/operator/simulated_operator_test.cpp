#include "nodes/device_bridge/operator/simulated_operator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/device_bridge/testing/toy_world.hpp"

namespace device_bridge {
namespace {

double Angle(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(core::RotationVector(a * glm::conjugate(b)));
}

TEST(SimulatedOperator, ReachesTheTargetClosedLoopFromTenSeeds) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ToyWorld world("step a\nreach thing.spot offset 0 0 0.05 turn 0 0 30 speed 0.4 within 0.002\n", seed);
    world.physics.bodies[0].X_WO = {core::QuaternionFromRollPitchYaw({0.3, -0.2, 0.5}), {0.2, 0.1, -0.15}};
    ASSERT_TRUE(world.RunLines(1, 8.0)) << "seed " << seed;
    const core::Pose goal = world.physics.bodies[0].X_WO * core::Pose{{1, 0, 0, 0}, {0, 0, 0.07}} *
                            core::Pose{core::QuaternionFromRollPitchYaw({0, 0, 0.5235987755982988}), glm::dvec3(0.0)};
    EXPECT_LT(glm::length(world.X_WD().translation - goal.translation), 0.0025) << "seed " << seed;
    EXPECT_LT(Angle(world.X_WD().rotation, goal.rotation), 0.05) << "seed " << seed;
    EXPECT_EQ(world.records()[0].outcome, LineOutcome::kDone);
    EXPECT_GE(world.records()[0].num_strokes, 2) << "an end-point error of 5 % of 0.27 m needs a correction";
  }
}

TEST(SimulatedOperator, MovesWithAMinimumJerkStrokeOfTheGivenPeakSpeed) {
  ToyWorld world("step a\nreach thing speed 0.3\n", 3);
  world.physics.bodies[0].X_WO.translation = {0.3, 0, 0};
  double peak = 0.0;
  for (int i = 0; i < 3000; ++i) {
    world.Tick();
    peak = std::max(peak, glm::length(world.outputs.states[0].V_WD.linear_m_per_s));
  }
  EXPECT_NEAR(peak, 0.3, 0.02);
}

TEST(SimulatedOperator, MovementIsReproducibleAndDependsOnTheSeed) {
  const auto run = [](std::uint64_t seed) {
    ToyWorld world("step a\nreach thing.spot\n", seed);
    world.physics.bodies[0].X_WO.translation = {0.2, 0, 0};
    world.Run(1.5);
    return world.X_WD().translation;
  };
  const glm::dvec3 first = run(7);
  const glm::dvec3 second = run(7);
  EXPECT_EQ(first, second);
  EXPECT_NE(first, run(8));
}

TEST(SimulatedOperator, NeverReactsWithin200Ms) {
  // Two worlds, equal up to t0; then one visible quantity changes in one of them.
  const std::string script =
      "step a\nreach thing.spot\npush 0 0 1 by 0.5 until state switch 1\nstep b\nreach goal.spot\n";
  for (int change = 0; change < 3; ++change) {
    for (const int t0 : {400, 900, 1500, 6000}) {
      ToyWorld same(script);
      ToyWorld other(script);
      same.physics.bodies[0].X_WO.translation = other.physics.bodies[0].X_WO.translation = {0.2, 0, 0};
      int first_difference_ms = -1;
      for (int i = 0; i < t0 + 2000 && first_difference_ms < 0; ++i) {
        if (i == t0) {
          if (change == 0) other.physics.bodies[0].X_WO.translation = {0.0, 0.3, 0.1};
          if (change == 1) other.logic.step = "b";
          if (change == 2) other.physics.mechanisms[1].state = 1;
        }
        same.Tick();
        other.Tick();
        const HandTarget& a = same.bridge->simulated_operator().target(0);
        const HandTarget& b = other.bridge->simulated_operator().target(0);
        if (a.X_WT.translation != b.X_WT.translation || a.opening_m != b.opening_m ||
            a.V_WT.linear_m_per_s != b.V_WT.linear_m_per_s) {
          first_difference_ms = i - t0;
        }
      }
      if (first_difference_ms >= 0) {
        EXPECT_GE(first_difference_ms, 200) << change << ' ' << t0;
      }
      if (change == 1) {
        EXPECT_LT(first_difference_ms, 300) << t0;
        EXPECT_GE(first_difference_ms, 200) << "the change must be seen at all";
      }
    }
  }
}

TEST(SimulatedOperator, ActsOnTheDeviceOnlyThroughTheHandsForce) {
  ToyWorld world("step a\nreach thing.spot\ngrip 0.01\n", 1, [](scene::Scenario& scenario) {
    scenario.devices[0].hand_stiffness_N_per_m = 0.0;
    scenario.devices[0].hand_damping_N_s_per_m = 0.0;
    scenario.devices[0].hand_stiffness_Nm_per_rad = 0.0;
    scenario.devices[0].hand_damping_Nm_s_per_rad = 0.0;
  });
  world.physics.bodies[0].X_WO.translation = {0.2, 0, 0};
  world.Run(3.0);
  EXPECT_GT(glm::length(world.bridge->simulated_operator().target(0).X_WT.translation), 0.1);  // the target moved
  EXPECT_LT(glm::length(world.X_WD().translation), 1e-12);
}

core::Wrench Wall(const core::DeviceState& state, double z_m, double K = 2500.0, double B = 20.0) {
  const double depth_m = z_m - state.X_WD.translation.z;
  if (depth_m <= 0.0) return {};
  return {{0, 0, std::max(0.0, K * depth_m - B * state.V_WD.linear_m_per_s.z)}, glm::dvec3(0.0)};
}

TEST(SimulatedOperator, StopsPushingWhenItFeelsTheGivenForce) {
  ToyWorld world("step a\nwait 1\npush 0 0 -1 by 0.1 speed 0.05 until felt 8\nwait 2\n");
  world.contact = [](const core::DeviceState& state) { return Wall(state, -0.02); };
  ASSERT_TRUE(world.RunLines(2, 10.0));
  EXPECT_EQ(world.records()[1].outcome, LineOutcome::kDone);
  const double when_done_N = world.outputs.applied[0].force_N.z;
  EXPECT_LT(when_done_N, 8.0 + 0.05 * 0.2 * 800.0);
  world.Run(1.0);
  EXPECT_LT(world.outputs.applied[0].force_N.z, 8.0);
  EXPECT_GT(world.outputs.applied[0].force_N.z, 0.5) << "still touching";
  EXPECT_LT(world.bridge->figures(0).peak_force_N, 8.0 + 0.05 * 0.2 * 800.0);
}

// The force vanishes while the hand presses: for a second, and for just longer than the hold and fade.
TEST(SimulatedOperator, StaysAtTheWallWhileTheForceIsLostAndContinuesAfterwards) {
  for (const double away_s : {1.0, 0.07}) {
    ToyWorld world("step a\npush 0 0 -1 by 0.2 speed 0.05 until felt 20\nwait 1\n");
    world.contact = [](const core::DeviceState& state) { return Wall(state, -0.02); };
    while (world.outputs.applied.empty() || world.outputs.applied[0].force_N.z < 16.0) world.Tick();
    const double before_m = world.X_WD().translation.z;
    double deepest_m = before_m;
    const auto observe = [&](double seconds) {
      for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
        world.Tick();
        deepest_m = std::min(deepest_m, world.X_WD().translation.z);
      }
    };
    world.is_linked = false;
    observe(away_s);
    world.is_linked = true;
    observe(0.5);
    // Its spring alone would move it by 16 N / 800 N/m = 20 mm.
    EXPECT_GT(deepest_m, before_m - 0.009) << away_s;
    ASSERT_TRUE(world.RunLines(1, 10.0));
    EXPECT_EQ(world.records()[0].outcome, LineOutcome::kDone) << away_s;
  }
}

TEST(SimulatedOperator, ReportsAPushThatEndsWithoutItsCondition) {
  ToyWorld world("step a\npush 0 0 -1 by 0.03 speed 0.1 until felt 8\npush 1 0 0 by 0.02\n");
  ASSERT_TRUE(world.RunLines(2, 10.0));
  EXPECT_EQ(world.records()[0].outcome, LineOutcome::kDistanceUsedUp);
  EXPECT_EQ(world.records()[1].outcome, LineOutcome::kDone) << "without a condition the distance is all there is to do";
  EXPECT_NEAR(world.X_WD().translation.z, -0.03, 0.001);
  world.Run(0.3);
  EXPECT_NEAR(world.X_WD().translation.x, 0.02, 0.001);
}

TEST(SimulatedOperator, NeverPushesHarderThanItsShareOfTheCap) {
  ToyWorld world("step a\npush 0 0 -1 by 0.5 speed 0.05 until engaged latch\n", 1,
                 [](scene::Scenario& scenario) { scenario.force_cap_N = 30.0; });
  world.contact = [](const core::DeviceState& state) { return Wall(state, -0.02); };
  world.Run(15.0);
  EXPECT_LT(world.bridge->figures(0).peak_force_N, 30.0 + 1e-9);
  EXPECT_GT(world.bridge->figures(0).peak_force_N, 20.0);
  EXPECT_EQ(world.bridge->figures(0).samples_over_limit, 0U);
}

TEST(SimulatedOperator, FindsAHoleBySpiralSearch) {
  // A wall with a hole of 0.4 mm radius, 1 mm beside the line of the push.
  for (const bool has_hole : {true, false}) {
    ToyWorld world("step a\npush 0 0 -1 by 0.03 speed 0.05 until engaged latch\n", 5);
    bool is_in_hole = false;
    world.contact = [&](const core::DeviceState& state) {
      const glm::dvec3 p = state.X_WD.translation;
      if (has_hole && std::hypot(p.x - 0.0007, p.y - 0.0007) < 0.0004) is_in_hole = true;
      return is_in_hole ? core::Wrench{} : Wall(state, -0.01);
    };
    world.after = [](ToyWorld& w) {
      if (w.X_WD().translation.z < -0.025) w.physics.mechanisms[0].state = 1;
    };
    ASSERT_TRUE(world.RunLines(1, 20.0));
    EXPECT_EQ(world.records()[0].outcome, has_hole ? LineOutcome::kDone : LineOutcome::kDistanceUsedUp);
  }
}

TEST(SimulatedOperator, CarriesTheHeldFrameToTheGoalFrameWithItsOrientation) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    ToyWorld world("step a\ncarry thing.spot to goal.spot offset 0 0 0.03 speed 0.3\n", seed);
    const core::Pose X_DThing{core::QuaternionFromRollPitchYaw({0.4, 0.1, -0.3}), {0.01, -0.02, 0.06}};
    world.physics.bodies[1].X_WO = {core::QuaternionFromRollPitchYaw({0.0, 0.5, 0.4}), {0.15, 0.1, 0.2}};
    world.after = [&](ToyWorld& w) { w.physics.bodies[0].X_WO = w.X_WD() * X_DThing; };
    ASSERT_TRUE(world.RunLines(1, 10.0)) << seed;
    const core::Pose X_OSpot{{1, 0, 0, 0}, {0, 0, 0.02}};
    const core::Pose moved = world.physics.bodies[0].X_WO * X_OSpot;
    const core::Pose goal = world.physics.bodies[1].X_WO * X_OSpot * core::Pose{{1, 0, 0, 0}, {0, 0, 0.03}};
    EXPECT_LT(glm::length(moved.translation - goal.translation), 0.0025);
    EXPECT_LT(Angle(moved.rotation, goal.rotation), 0.05);
  }
}

TEST(SimulatedOperator, GripsWithTheGivenForceAndWaitsUntilItHolds) {
  ToyWorld world("step a\nwait 1.2\ngrip 0 force 15\nwait until held thing\ngrip 0.05\nwait until released\n");
  world.jaws = [](const core::DeviceState& state) { return 8000.0 * std::max(0.0, 0.03 - state.opening_m); };
  ASSERT_TRUE(world.RunLines(2, 6.0));
  EXPECT_NEAR(world.outputs.states[0].opening_m, 0.03 - 15.0 / 8000.0, 2e-4);
  world.Run(1.0);
  EXPECT_EQ(world.records().size(), 2U) << "it does not hold yet";
  world.grasped = 0;
  ASSERT_TRUE(world.RunLines(4, 3.0));
  EXPECT_NEAR(world.outputs.states[0].opening_m, 0.05, 1e-3);
  world.grasped = core::kNoObject;
  EXPECT_TRUE(world.RunLines(5, 0.4));
}

// N = 1.4 L / (2 mu), at friction 0.4; never more than the strongest, 15 N.
TEST(SimulatedOperator, GripsNoHarderThanTheLoadAsks) {
  ToyWorld world("step a\nwait 1.2\ngrip 0 force 15 friction 0.4\nwait 60\n");
  world.jaws = [](const core::DeviceState& state) { return 8000.0 * std::max(0.0, 0.03 - state.opening_m); };
  double load_N = 2.0;
  world.contact = [&](const core::DeviceState&) { return core::Wrench{{0.0, 0.0, -load_N}, {}}; };
  ASSERT_TRUE(world.RunLines(2, 6.0));
  const auto pressed_N = [&] { return 8000.0 * (0.03 - world.outputs.states[0].opening_m); };
  for (const auto& [load, expected_N] : {std::pair{2.0, 3.5}, {6.0, 10.5}, {30.0, 15.0}, {4.0, 7.0}}) {
    load_N = load;
    world.Run(2.0);
    EXPECT_NEAR(pressed_N(), expected_N, 0.05 * expected_N) << load;
  }
}

TEST(SimulatedOperator, ANewStepEndsTheLinesOfThePreviousOne) {
  ToyWorld world("step a\nwait 100\nwait 1\nstep b\npush 1 0 0 by 0.02 speed 0.1\n");
  world.Run(1.0);
  EXPECT_TRUE(world.records().empty());
  world.logic.step = "b";
  ASSERT_TRUE(world.RunLines(2, 2.0));
  EXPECT_EQ(world.records()[0].outcome, LineOutcome::kAbandoned);
  EXPECT_EQ(world.records()[1].step, 1);
  world.logic.step = "unknown";
  world.Run(1.0);
  EXPECT_TRUE(world.bridge->simulated_operator().is_idle());
}

TEST(SimulatedOperator, RepeatsItsLinesWhenAStepDoesNotEnd) {
  ToyWorld world("step a\nwait 0.5\nwait 0.2\n");
  ASSERT_TRUE(world.RunLines(2, 2.0));
  world.Run(3.5);
  EXPECT_EQ(world.records().size(), 2U);
  ASSERT_TRUE(world.RunLines(4, 2.0));
  EXPECT_EQ(world.records()[2].line, world.records()[0].line);
}

TEST(SimulatedOperator, RelaxesAPushThatANewStepInterrupts) {
  for (const char* next : {"wait 2\n", "push 1 0 0 by 0.02 speed 0.02\n"}) {
    ToyWorld world(std::string("step a\npush 0 0 -1 by 0.1 speed 0.05 until engaged latch\nstep b\n") + next);
    world.contact = [](const core::DeviceState& state) { return Wall(state, -0.02); };
    world.Run(1.1);
    const double pressed_N = world.outputs.applied[0].force_N.z;
    ASSERT_GT(pressed_N, 8.0);
    world.logic.step = "b";
    world.Run(0.7);
    ASSERT_EQ(world.records().size(), 1U);
    EXPECT_EQ(world.records()[0].outcome, LineOutcome::kAbandoned);
    EXPECT_EQ(world.records()[0].step, 0);
    EXPECT_LT(world.outputs.applied[0].force_N.z, 0.5 * pressed_N) << next;
  }
}

}  // namespace
}  // namespace device_bridge
