#include <LinearMath/btAlignedAllocator.h>

#include "core/testing/allocations.hpp"
#include "physics/cloth/cloth.hpp"
#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/testing/bodies.hpp"
#include "physics/testing/floor.hpp"

namespace physics {
namespace {

TEST(World, StepDoesNotAllocateEvenWhenContactsAppear) {
  btAlignedAllocSetCustom([](std::size_t size) { return operator new(size); },
                          [](void* memory) { operator delete(memory); });
  {
    World world;
    const int a = test::AddDynamic(&world, {}, BoxMass(1.0, {0.1, 0.1, 0.1}));
    const int b = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.1, 0, 0}}, BoxMass(2.0, {0.1, 0.1, 0.1}));
    const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {}, {}, {}});
    const int pair = world.AddContactPair(a, b).value();
    const int push = world.AddContactPair(hand, a).value();
    SnapParams snap;
    snap.is_initially_engaged = true;
    snap.release_force_N = 1e3;
    trials::AddMechanism<Snap>(&world, world.world_body(), a, snap);
    HookAndLoopParams patches;
    patches.p_PPatch_m = {{0, 0, 0}, {0.1, 0, 0}};
    patches.stiffness_N_per_m = 1000.0;
    patches.release_force_N = 1e3;
    trials::AddMechanism<HookAndLoop>(&world, a, b, patches);
    core::ContactSet set;
    for (std::uint32_t i = 0; i < core::kMaxContactPlanes; ++i) {
      test::AddPlane(&set, i, {0.05, 0.001 * i, 0}, {-0.05, 0, 0}, {-1, 0, 0}, 1e4);
    }
    const std::uint64_t before = core::test::NumAllocations();
    ASSERT_GT(before, 0U);  // counting works
    world.Step(test::kDt);
    for (int i = 0; i < 200; ++i) {
      if (i == 20) world.SetContactPlanes(pair, set);
      if (i == 40) world.SetContactPlanes(push, set);
      world.SetKinematic(hand, {{1, 0, 0, 0}, {-0.1 + 1e-4 * i, 0, 0}}, {{}, {0.1, 0, 0}});
      world.Step(test::kDt);
    }
    EXPECT_EQ(core::test::NumAllocations(), before);
  }
  btAlignedAllocSetCustomAligned(nullptr, nullptr);
}

TEST(Cloth, StepDoesNotAllocateEvenWhenItIsGrippedAndTouches) {
  auto cloth = *Cloth::Create({});
  ClothBodyParams floor;
  floor.shape = std::make_shared<Floor>();
  floor.X_WO.translation.z = -0.01;
  ASSERT_TRUE(cloth->AddBody(floor).has_value());
  ClothBodyParams kinematic;
  kinematic.kind = BodyKind::kKinematic;
  const int hand = *cloth->AddBody(kinematic);
  ASSERT_TRUE(cloth->AddBond({0, 500.0, 1.0, 0.02}, {{0.01, 0.01, 0.0}}).has_value());
  const std::uint64_t before = core::test::NumAllocations();
  int num_gripped = 0;
  for (int i = 0; i < 300; ++i) {
    if (i == 50) num_gripped = cloth->Grip({hand, 100.0, 1.0}, {-0.06, -0.06, -0.06}, {0.0, 0.0, 0.06});
    if (i == 250) cloth->Release(hand);
    cloth->SetBody(hand, {{1, 0, 0, 0}, {0.0, 0.0, -2e-4 * i}});
    cloth->Step(test::kDt);
  }
  EXPECT_EQ(core::test::NumAllocations(), before);
  EXPECT_GT(num_gripped, 4);
  EXPECT_EQ(cloth->held(0), 0);
}

}  // namespace
}  // namespace physics
