#include "physics/checkpoint.hpp"

#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/test_support.hpp"

namespace physics {
namespace {

// Everything at once: stacked blocks in frictional contact under load, a lever, a snap, patches, a grasp.
struct Busy {
  World world;
  int low = -1, pair = -1, push = -1;

  Busy() {
    low = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.05}}, BoxMass(0.2, {0.1, 0.1, 0.1}), {{0, 0.1, 0.2}, {}});
    const int high = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.151}}, BoxMass(20.0, {0.1, 0.1, 0.1}));
    pair = world.AddContactPair(low, world.world_body()).value();
    const int upper = world.AddContactPair(high, low).value();
    push = world.AddContactPair(high, world.world_body()).value();
    world.SetContactPlanes(pair, Feet(0.0));
    world.SetContactPlanes(upper, Feet(0.05));
    world.SetContactWrench(push, {{3, 0, -100}, {}});
    HingeParams hinge;
    hinge.has_detents = true;
    hinge.detents_rad[0] = -0.3;
    hinge.detents_rad[1] = 0.3;
    hinge.detent_torque_Nm = 0.1;
    const int lever = test::AddDynamic(&world, HingePose(hinge, -0.2), BoxMass(0.05, {0.01, 0.05, 0.01}));
    test::MustAddMechanism<Hinge>(&world, world.world_body(), lever, hinge);
    HookAndLoopParams patches;
    patches.p_PPatch_m = {{0, 0, 0}, {0.1, 0, 0}};
    patches.X_PC = world.X_WO(lever);
    patches.stiffness_N_per_m = 500.0;
    patches.release_force_N = 0.5;
    test::MustAddMechanism<HookAndLoop>(&world, world.world_body(), lever, patches);
    SnapParams snap;
    snap.engage_force_N = 5.0;
    snap.release_force_N = 8.0;
    const int plug =
        test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.005}}, BoxMass(0.3, {0.03, 0.03, 0.1}), {{}, {0, 0, -0.3}});
    test::MustAddMechanism<Snap>(&world, world.world_body(), plug, snap);
    const int held = test::AddDynamic(&world, {}, BoxMass(0.3, {0.03, 0.03, 0.1}), {{0, 1, 0}, {}});
    auto* grasp = test::MustAddMechanism<SpringCoupling>(&world, plug, held, SpringCouplingParams{});
    grasp->Attach(world.X_WO(plug), world.X_WO(held), {0, 0, 0});
  }
  static core::ContactSet Feet(double top) {
    core::ContactSet set;
    set.friction = 0.2f;
    set.damping_N_s_per_m = 10.0f;
    std::uint32_t id = 0;
    for (const double x : {-0.05, 0.05}) {
      for (const double y : {-0.05, 0.05}) test::AddPlane(&set, ++id, {x, y, -0.05}, {x, y, top}, {0, 0, 1}, 1e5);
    }
    return set;
  }
  void Run(int steps) {
    for (int i = 0; i < steps; ++i) world.Step(test::kDt);
  }
};

TEST(Checkpoint, RestoredRunGoesOnBitForBit) {
  Busy whole;
  whole.Run(333);
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  Busy restored;
  restored.Run(50);  // anywhere else
  ASSERT_TRUE(restored.world.Restore(&checkpoint).has_value());
  EXPECT_EQ(restored.world.StateHash(), whole.world.StateHash());
  for (int i = 0; i < 700; ++i) {
    whole.Run(1);
    restored.Run(1);
    ASSERT_EQ(restored.world.StateHash(), whole.world.StateHash()) << i;
  }
  EXPECT_EQ(restored.world.impulse_balance().linear_magnitude_Ns, whole.world.impulse_balance().linear_magnitude_Ns);
}

TEST(Checkpoint, PosesAndVelocitiesAloneAreNotEnough) {
  // What the impulses of the last step are for: without them the next one differs.
  Busy whole;
  whole.Run(333);
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  Busy restored;
  ASSERT_TRUE(restored.world.Restore(&checkpoint).has_value());
  restored.world.ClearContact(restored.pair);
  restored.world.SetContactPlanes(restored.pair, Busy::Feet(0.0));
  whole.Run(50);
  restored.Run(50);
  EXPECT_NE(restored.world.StateHash(), whole.world.StateHash());
}

TEST(Checkpoint, OfAnotherWorldIsRefused) {
  Busy whole;
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  World other;
  const auto restored = other.Restore(&checkpoint);
  ASSERT_FALSE(restored.has_value());
  EXPECT_NE(restored.error().detail.find("another world"), std::string::npos);
}

}  // namespace
}  // namespace physics
