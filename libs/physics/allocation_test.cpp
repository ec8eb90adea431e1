#include <LinearMath/btAlignedAllocator.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/snap.hpp"
#include "physics/test_support.hpp"

namespace {
std::atomic<long> g_allocations{0};
void* CountedBulletAlloc(std::size_t size, int alignment) {
  ++g_allocations;
  return std::aligned_alloc(static_cast<std::size_t>(alignment), (size + static_cast<std::size_t>(alignment) - 1) /
                                                                     static_cast<std::size_t>(alignment) *
                                                                     static_cast<std::size_t>(alignment));
}
void CountedBulletFree(void* memory) {
  std::free(memory);
}
}  // namespace

// Not inlined, else GCC sees free() on memory from new and warns.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++g_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace physics {
namespace {

TEST(World, StepDoesNotAllocateEvenWhenContactsAppear) {
  btAlignedAllocSetCustomAligned(CountedBulletAlloc, CountedBulletFree);
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
    test::MustAddMechanism<Snap>(&world, world.world_body(), a, snap);
    HookAndLoopParams patches;
    patches.p_PPatch_m = {{0, 0, 0}, {0.1, 0, 0}};
    patches.stiffness_N_per_m = 1000.0;
    patches.release_force_N = 1e3;
    test::MustAddMechanism<HookAndLoop>(&world, a, b, patches);
    core::ContactSet set;
    for (std::uint32_t i = 0; i < core::kMaxContactPlanes; ++i) {
      test::AddPlane(&set, i, {0.05, 0.001 * i, 0}, {-0.05, 0, 0}, {-1, 0, 0}, 1e4);
    }
    const long before = g_allocations;
    ASSERT_GT(before, 0);  // counting works
    world.Step(test::kDt);
    for (int i = 0; i < 200; ++i) {
      if (i == 20) world.SetContactPlanes(pair, set);
      if (i == 40) world.SetContactPlanes(push, set);
      world.SetKinematic(hand, {{1, 0, 0, 0}, {-0.1 + 1e-4 * i, 0, 0}}, {{}, {0.1, 0, 0}});
      world.Step(test::kDt);
    }
    EXPECT_EQ(g_allocations - before, 0);
  }
  btAlignedAllocSetCustomAligned(nullptr, nullptr);
}

}  // namespace
}  // namespace physics
