#include "physics/live_change.hpp"

#include <cmath>
#include <limits>

#include "physics/checkpoint.hpp"
#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/test_support.hpp"

namespace physics {
namespace {

using test::kDt;

// A part that is held to W by a snap without damping and pulled by a constant force.
struct LoadedSnap {
  static constexpr double kMass = 0.3;
  World world;
  SnapParams params;
  int part = -1, pull = -1, stiffness = -1;
  double pull_N = 0.0;

  explicit LoadedSnap(double force_N, double speed = 0.0) : pull_N(force_N) {
    params.engage_force_N = 15.0;
    params.release_force_N = 60.0;
    params.damping_N_s_per_m = 0.0;
    params.is_initially_engaged = true;
    const double z_m = force_N / params.stiffness_N_per_m;
    part =
        test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, z_m}}, BoxMass(kMass, {0.05, 0.05, 0.05}), {{}, {0, 0, speed}});
    test::MustAddMechanism<Snap>(&world, world.world_body(), part, params);
    pull = world.AddContactPair(part, world.world_body()).value();
    world.SetContactWrench(pull, {{0, 0, force_N}, {}});
    stiffness = world.FindTunable(0, "stiffness_N_per_m");
  }
  // Kinetic energy, the spring's and the load's, from momentum and pose alone; the place half a step back goes with the
  // speed.
  [[nodiscard]] double Energy_J(double k) const {
    const double p = world.momentum_Ns(part).z;
    const double z = world.center_of_mass_W(part).z - 0.5 * kDt * p / kMass;
    return 0.5 * p * p / kMass + 0.5 * k * z * z - pull_N * z;
  }
  void Run(int steps) {
    for (int i = 0; i < steps; ++i) world.Step(kDt);
  }
};

TEST(LiveChange, AStiffnessStepUnderLoadInjectsHalfDkTimesXSquaredAndTheMotionHasIt) {
  for (const double factor : {0.5, 1.5, 2.0, 2.9}) {
    LoadedSnap scene(20.0);
    scene.Run(50);
    const double k = scene.params.stiffness_N_per_m;
    const double x = scene.world.center_of_mass_W(scene.part).z;
    ASSERT_NEAR(x, 0.001, 1e-12);
    const double before_J = scene.Energy_J(k);
    const ChangeReport report = scene.world.BeginChange(0, scene.stiffness, {factor * k});
    EXPECT_EQ(report.first_tick, scene.world.num_steps() + 1);
    EXPECT_EQ(report.last_tick, report.first_tick);
    const double expected_J = 0.5 * (factor - 1.0) * k * x * x;
    EXPECT_NEAR(report.injected_J / expected_J, 1.0, 1e-6);
    // The scene's energy, measured on the part's motion over many periods afterwards.
    for (int i = 0; i < 300; ++i) {
      scene.Run(1);
      ASSERT_NEAR((scene.Energy_J(factor * k) - before_J) / expected_J, 1.0, 1e-6) << factor << " step " << i;
    }
  }
}

TEST(LiveChange, ARampReportsTheSumOfWhatItInjectedOnItsWay) {
  LoadedSnap scene(20.0, 0.02);  // in motion: every part of the ramp meets another deflection
  const double k = scene.params.stiffness_N_per_m;
  double energy_J = scene.Energy_J(k);
  double injected_J = 0.0;
  EXPECT_EQ(scene.world.BeginChange(0, scene.stiffness, {1.5 * k, ChangeMode::kRamped, 0.1}).first_tick, 0u);
  double value = k;
  for (int i = 1; i <= 100; ++i) {
    const double z = scene.world.center_of_mass_W(scene.part).z;
    const double next = k + 0.5 * k * i / 100.0;
    injected_J += 0.5 * (next - value) * z * z;
    value = next;
    scene.Run(1);
    EXPECT_EQ(scene.world.change_report(0, scene.stiffness).last_tick, i < 100 ? 0u : 100u);
  }
  const ChangeReport& report = scene.world.change_report(0, scene.stiffness);
  EXPECT_EQ(report.first_tick, 1u);
  EXPECT_NEAR(report.injected_J / injected_J, 1.0, 1e-9);
  EXPECT_EQ(*scene.world.mechanism(0).tunables()[static_cast<std::size_t>(scene.stiffness)].value, 1.5 * k);
  // The motion has it up to what the poses move within half a step.
  EXPECT_NEAR((scene.Energy_J(1.5 * k) - energy_J) / injected_J, 1.0, 0.01);
}

TEST(LiveChange, WhatWaitsForSeparationComesWithTheStepThatFindsItAndInjectsNothing) {
  World world;
  const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {}, {}, {}});
  const int part = test::AddDynamic(&world, {}, BoxMass(0.5, {0.1, 0.1, 0.1}));
  auto* grasp = test::MustAddMechanism<SpringCoupling>(&world, hand, part, SpringCouplingParams{});
  grasp->Attach({{1, 0, 0, 0}, {0.002, 0, 0}}, {}, {0, 0, 0});  // strained
  const int stiffness = world.FindTunable(0, "stiffness_N_per_m");
  world.BeginChange(0, stiffness, {9000.0, ChangeMode::kWhenSeparated});
  for (int i = 0; i < 20; ++i) world.Step(kDt);
  EXPECT_EQ(world.change_report(0, stiffness).first_tick, 0u);
  EXPECT_EQ(*world.mechanism(0).tunables()[static_cast<std::size_t>(stiffness)].value, 3000.0);
  grasp->Detach();
  world.Step(kDt);
  EXPECT_EQ(world.change_report(0, stiffness).first_tick, 21u);
  EXPECT_EQ(world.change_report(0, stiffness).injected_J, 0.0);
  EXPECT_EQ(*world.mechanism(0).tunables()[static_cast<std::size_t>(stiffness)].value, 9000.0);
}

TEST(LiveChange, AnAxisCanBeLockedAndFreed) {
  World world;
  HingeParams params;
  const int door = test::AddDynamic(&world, {}, BoxMass(1.0, {0.2, 0.2, 0.02}), {{0, 0, 1.0}, {}});
  test::MustAddMechanism<Hinge>(&world, world.world_body(), door, params);
  const int locked = world.FindTunable(0, "locked");
  for (int i = 0; i < 100; ++i) world.Step(kDt);
  EXPECT_NEAR(world.mechanism(0).position(), 0.1, 2e-3);
  EXPECT_EQ(world.BeginChange(0, locked, {1.0}).injected_J, 0.0);
  world.Step(kDt);
  const double held = world.mechanism(0).position();
  const int push = world.AddContactPair(door, world.world_body()).value();
  world.SetContactWrench(push, {{}, {0, 0, 5.0}});
  for (int i = 0; i < 500; ++i) world.Step(kDt);
  EXPECT_NEAR(world.mechanism(0).position(), held, 1e-9);
  EXPECT_NEAR(world.mechanism(0).force(), -5.0, 1e-6);
  world.BeginChange(0, locked, {0.0});
  for (int i = 0; i < 20; ++i) world.Step(kDt);
  EXPECT_GT(world.mechanism(0).position(), held + 0.1);
}

TEST(LiveChange, ARampGoesOnBitForBitFromACheckpoint) {
  LoadedSnap straight(20.0, 0.02);
  straight.world.BeginChange(0, straight.stiffness, {3.0e4, ChangeMode::kRamped, 0.2});
  straight.Run(70);
  Checkpoint saved;
  straight.world.Save(&saved);
  straight.Run(300);
  LoadedSnap restored(20.0);
  ASSERT_TRUE(restored.world.Restore(&saved).has_value());
  restored.Run(300);
  EXPECT_EQ(restored.world.StateHash(), straight.world.StateHash());
  EXPECT_EQ(restored.world.change_report(0, restored.stiffness).injected_J,
            straight.world.change_report(0, straight.stiffness).injected_J);
}

TEST(LiveChange, RefusesWhatMakesNoSense) {
  LoadedSnap scene(0.0);
  EXPECT_EQ(scene.world.FindTunable(0, "colour"), -1);
  EXPECT_TRUE(scene.world.CanChange(0, scene.stiffness, {1.0}));
  EXPECT_FALSE(scene.world.CanChange(0, scene.stiffness, {-1.0}));
  EXPECT_FALSE(scene.world.CanChange(0, scene.stiffness, {std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_FALSE(scene.world.CanChange(0, scene.stiffness, {1.0, ChangeMode::kRamped, -1.0}));
  EXPECT_FALSE(scene.world.CanChange(0, -1, {1.0}));
}

}  // namespace
}  // namespace physics
