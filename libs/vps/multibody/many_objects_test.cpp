#include "vps/testing/many_objects.hpp"

#include <gtest/gtest.h>

#include "bus/rt/worker_pool.hpp"
#include "core/testing/allocations.hpp"

namespace {
std::atomic<long> g_allocations{0};
}  // namespace
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
    bus::WorkerPool workers(2);
    std::array<std::uint32_t, kNumPairStates> seen{};
    const std::uint64_t before = core::test::NumAllocations();
    for (int step = 0; step < test::ManyObjects::kPeriod; step += kStride) {
      // All at once in one heap and back: every pair goes through every state.
      if (step % 500 == 250) {
        for (std::size_t i = 0; i < 60; ++i) scene.world().SetPose(i, {{1, 0, 0, 0}, {0.002 * i, 0, 0}});
      } else if (step % 50 != 0) {
        scene.MoveTo(step);
      }
      scene.world().SetActive(7, step % 100 != 0);
      scene.world().SetStiffness(1, 1000.0 + step);
      scene.world().Step(&workers, step % 200 == 0 ? 1 : 0);
      const auto counts = scene.world().CountStates();
      for (std::size_t k = 0; k < counts.size(); ++k) seen[k] += counts[k];
    }
    EXPECT_EQ(core::test::NumAllocations(), before);
    for (const std::uint32_t count : seen) EXPECT_GT(count, 0U);
  }
}

TEST(ManyObjects, WorkersChangeNoBit) {
  for (const Method method : {Method::kPaper, Method::kFast}) {
    core::SerialFor serial;
    for (const unsigned num_workers : {2U, 3U}) {
      test::ManyObjects one(method, Parts(method), 30, 0);
      test::ManyObjects other(method, Parts(method), 30, 0);
      bus::WorkerPool workers(num_workers);
      for (int step = 0; step < test::ManyObjects::kPeriod; step += 5 * kStride) {
        one.MoveTo(step);
        other.MoveTo(step);
        one.world().Step(&serial);
        other.world().Step(&workers);
        for (std::size_t i = 0; i < one.world().num_objects(); ++i) {
          ASSERT_EQ(one.world().ObjectWrench(i).force_N, other.world().ObjectWrench(i).force_N);
          ASSERT_EQ(one.world().ObjectWrench(i).torque_Nm, other.world().ObjectWrench(i).torque_Nm);
        }
      }
    }
  }
}

// One pair whose walk is cut into chunks: a peg along the wall of its hole.
TEST(HeavyPair, IsSharedAmongWorkersWithoutChangingABit) {
  WorldDescription description;
  description.method = Method::kFast;
  const CookParameters field{0.0005, 0, Method::kFast};
  const CookParameters samples{0.0, 20000, Method::kFast};
  description.objects = {
      {std::make_shared<const CookedObject>(*Cook(MakeBlockWithHole(0.03, 0.03, 0.01005, 96), field)), {}},
      {std::make_shared<const CookedObject>(*Cook(MakeCylinder(0.01, 0.03, 96), samples)), {}}};
  description.pairs = {{.sampled = 1, .field = 0, .accuracy = 0.01}};
  const auto one = *CollisionWorld::Create(description);
  const auto other = *CollisionWorld::Create(description);
  core::SerialFor serial;
  bus::WorkerPool workers(3);
  for (int step = 0; step < 200; ++step) {
    const double t = 0.03 * step;
    const core::Pose X{core::QuaternionFromRotationVector({0.002 * std::sin(t), 0.0, t}),
                       {1.2e-4 * std::cos(3.0 * t), 1.2e-4 * std::sin(3.0 * t), 0.001 * t}};
    one->SetPose(1, X);
    other->SetPose(1, X);
    ASSERT_EQ(one->Step(&serial).pairs_in_contact, 1U);
    other->Step(&workers);
    const PairResult& x = one->result(0);
    const PairResult& y = other->result(0);
    ASSERT_GT(x.counters.points_tested, 10000U);
    ASSERT_EQ(x.counters.points_colliding, y.counters.points_colliding);
    ASSERT_EQ(x.F_So_W.force_N, y.F_So_W.force_N);
    ASSERT_EQ(x.F_So_W.torque_Nm, y.F_So_W.torque_Nm);
    ASSERT_EQ(x.signed_distance_m, y.signed_distance_m);
    ASSERT_EQ(x.planes.size(), y.planes.size());
  }
}

TEST(ManyObjects, FarPairsAreRarelyTested) {
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
