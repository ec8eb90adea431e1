#include "vps/multibody/many_objects.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> g_allocations{0};
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

namespace vps {
namespace {

constexpr int kStride = 10;

const test::ManyObjects::Parts& Parts(Method method) {
  static const auto paper = test::ManyObjects::CookParts(Method::kPaper, 1500, 0.002);
  static const auto fast = test::ManyObjects::CookParts(Method::kFast, 1500, 0.002);
  return method == Method::kFast ? fast : paper;
}

TEST(ManyObjects, FiftyFarOnesChangeNothingForThoseThatTouch) {
  for (const Method method : {Method::kPaper, Method::kFast}) {
    test::ManyObjects few(method, Parts(method), 30, 0);
    test::ManyObjects many(method, Parts(method), 30, 50);
    core::SerialFor serial;
    std::uint32_t num_touching = 0;
    for (int step = 0; step < test::ManyObjects::kPeriod; step += kStride) {
      few.MoveTo(step);
      many.MoveTo(step);
      const StepReport a = few.world().Step(&serial);
      const StepReport b = many.world().Step(&serial);
      num_touching += a.pairs_in_contact;
      ASSERT_EQ(a.pairs_tested, b.pairs_tested);
      ASSERT_EQ(a.pairs_in_contact, b.pairs_in_contact);
      ASSERT_EQ(a.counters.spheres_tested, b.counters.spheres_tested);
      ASSERT_EQ(a.counters.points_tested, b.counters.points_tested);
      ASSERT_EQ(a.counters.points_colliding, b.counters.points_colliding);
      for (std::size_t i = 0; i < few.world().num_pairs(); ++i) {
        const PairResult& x = few.world().result(i);
        const PairResult& y = many.world().result(i);
        ASSERT_EQ(x.counters.spheres_tested, y.counters.spheres_tested);
        ASSERT_EQ(x.counters.points_tested, y.counters.points_tested);
        ASSERT_EQ(x.F_So_W.force_N, y.F_So_W.force_N);
        ASSERT_EQ(few.world().state(i), many.world().state(i));
      }
    }
    EXPECT_GT(num_touching, 9U * test::ManyObjects::kPeriod / kStride);
  }
}

TEST(ManyObjects, AWholeCycleDoesNotAllocate) {
  for (const Method method : {Method::kPaper, Method::kFast}) {
    test::ManyObjects scene(method, Parts(method), 60, 0);
    core::SerialFor serial;
    std::array<std::uint32_t, kNumPairStates> seen{};
    const long before = g_allocations;
    for (int step = 0; step < test::ManyObjects::kPeriod; step += kStride) {
      // All at once in one heap and back: every pair goes through every state.
      if (step % 500 == 250) {
        for (std::size_t i = 0; i < 60; ++i) scene.world().SetPose(i, {{1, 0, 0, 0}, {0.002 * i, 0, 0}});
      } else if (step % 50 != 0) {
        scene.MoveTo(step);
      }
      scene.world().SetActive(7, step % 100 != 0);
      scene.world().SetStiffness(1, 1000.0 + step);
      scene.world().Step(&serial, step % 200 == 0 ? 1 : 0);
      const auto counts = scene.world().CountStates();
      for (std::size_t k = 0; k < counts.size(); ++k) seen[k] += counts[k];
    }
    EXPECT_EQ(g_allocations - before, 0);
    for (const std::uint32_t count : seen) EXPECT_GT(count, 0U);
  }
}

TEST(ManyObjects, FarPairsAreNotLookedAt) {
  test::ManyObjects scene(Method::kFast, Parts(Method::kFast), 100, 0);
  core::SerialFor serial;
  scene.world().Step(&serial);
  std::uint64_t num_bounded = 0;
  std::uint64_t num_tested = 0;
  for (int step = 1; step < test::ManyObjects::kPeriod; ++step) {
    scene.MoveTo(step);
    const StepReport& report = scene.world().Step(&serial);
    num_bounded += report.pairs_bounded;
    num_tested += report.pairs_tested;
  }
  // Of 4950 pairs: ten touch, and fewer than one in two hundred has its spheres compared.
  EXPECT_LT(num_bounded, 25U * test::ManyObjects::kPeriod);
  EXPECT_LT(num_tested, 20U * test::ManyObjects::kPeriod);
  const auto counts = scene.world().CountStates();
  EXPECT_GT(counts[static_cast<std::size_t>(PairState::kFar)], 4800U);
}

}  // namespace
}  // namespace vps
