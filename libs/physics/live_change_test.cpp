#include "physics/live_change.hpp"

#include <cmath>
#include <limits>

#include "physics/checkpoint.hpp"
#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"
#include "physics/testing/trials/snaps.hpp"

namespace physics {
namespace {

using test::kDt;
using trials::LoadedSnap;

TEST(LiveChange, StiffnessStepUnderLoadAddsHalfDkTimesXSquaredToTheMotion) {
  for (const double factor : {0.5, 1.5, 2.0, 2.9}) {
    const trials::StiffnessStepError error = trials::StepOfStiffness(factor);
    EXPECT_LE(error.reported, 1e-6) << factor;
    EXPECT_LE(error.in_motion, 1e-6) << factor;
  }
}

TEST(LiveChange, ImmediateChangeIsReportedForTheNextTick) {
  LoadedSnap scene(20.0);
  scene.Run(50);
  const ChangeReport report = scene.world.BeginChange(0, scene.stiffness, {1.5 * scene.params.stiffness_N_per_m});
  EXPECT_EQ(report.first_tick, scene.world.num_steps() + 1);
  EXPECT_EQ(report.last_tick, report.first_tick);
}

TEST(LiveChange, RampReportsItsTotalInjectedEnergy) {
  LoadedSnap scene(20.0, 0.02);  // in motion: the deflection differs at every step of the ramp
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
  // The motion has that energy, up to the motion within half a step.
  EXPECT_NEAR((scene.Energy_J(1.5 * k) - energy_J) / injected_J, 1.0, 0.01);
}

TEST(LiveChange, ChangeAtSeparationComesWithTheStepThatFindsItAndInjectsNoEnergy) {
  World world;
  const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {}, {}, {}});
  const int part = test::AddDynamic(&world, {}, BoxMass(0.5, {0.1, 0.1, 0.1}));
  auto* grasp = trials::AddMechanism<SpringCoupling>(&world, hand, part, SpringCouplingParams{});
  grasp->Attach({{1, 0, 0, 0}, {0.002, 0, 0}}, {}, {0, 0, 0});  // strained
  const int stiffness = world.FindTunable(0, "stiffness_N_per_m");
  world.BeginChange(0, stiffness, {9000.0, ChangeMode::kWhenSeparated});
  for (int i = 0; i < 20; ++i) world.Step(kDt);
  EXPECT_EQ(world.change_report(0, stiffness).first_tick, 0u);
  EXPECT_EQ(*world.mechanism(0).tunables()[static_cast<std::size_t>(stiffness)].value,
            SpringCouplingParams{}.stiffness_N_per_m);
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
  trials::AddMechanism<Hinge>(&world, world.world_body(), door, params);
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

TEST(LiveChange, RampContinuesBitForBitFromACheckpoint) {
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

TEST(LiveChange, RefusesInvalidChanges) {
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
