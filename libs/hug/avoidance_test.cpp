#include "hug/avoidance.hpp"

#include <gtest/gtest.h>

#include "hug/machine.hpp"
#include "hug/noise.hpp"

namespace hug {
namespace {

TEST(Capsules, ClosestPointsAreTheLeastOfAllPairsOfPoints) {
  Noise noise(7);
  const auto random = [&] { return glm::dvec3(noise.Even(), noise.Even(), noise.Even()) - 0.5; };
  for (int i = 0; i < 200; ++i) {
    const Capsule first{random(), random(), 0.02}, second{random(), random(), 0.03};
    const ClosestPoints closest = Closest(first, second);
    double least_m = 1e9;
    for (int s = 0; s <= 100; ++s) {
      for (int t = 0; t <= 100; ++t) {
        least_m = std::min(least_m,
                           glm::distance(glm::mix(first.a, first.b, 0.01 * s), glm::mix(second.a, second.b, 0.01 * t)));
      }
    }
    EXPECT_LE(closest.distance_m, least_m - 0.05 + 1e-12);
    EXPECT_GE(closest.distance_m, least_m - 0.05 - 0.01);  // the grid's own error
    EXPECT_NEAR(closest.distance_m, glm::distance(closest.on_first, closest.on_second) - 0.05, 1e-12);
  }
}

TEST(Capsules, APointAndParallelBarsAreNoSpecialCase) {
  const Capsule bar{{0, 0, 0}, {1, 0, 0}, 0.1};
  EXPECT_NEAR(Closest(bar, {{0.3, 0.5, 0}, {0.3, 0.5, 0}, 0.1}).distance_m, 0.3, 1e-12);
  EXPECT_NEAR(Closest(bar, {{0.5, 0.5, 0}, {2.0, 0.5, 0}, 0.1}).distance_m, 0.3, 1e-12);
  EXPECT_NEAR(Closest(bar, {{3.0, 0.0, 0}, {2.0, 0.0, 0}, 0.1}).distance_m, 0.8, 1e-12);
}

// Both hands pull towards each other with 40 N: the arms come near and do not touch.
TEST(Avoidance, ArmsThatHandsDriveTogetherDoNotTouch) {
  Machine machine{MachineFigures{}};
  Hand hands[2];
  const Side sides[2] = {Side::kRight, Side::kLeft};
  for (int i = 0; i < 2; ++i) {
    const core::Pose X_WD{{1, 0, 0, 0}, {0.6, i == 0 ? -0.25 : 0.25, 0.2}};
    ASSERT_TRUE(machine.Open(sides[i], ArmFigures{}, X_WD));
    hands[i].X_WT = X_WD;
    hands[i].holds_dead_man = true;
  }
  for (std::int64_t ms = 0; ms < 6000; ++ms) {
    machine.AdvanceTo(ms * 1'000'000);
    for (int i = 0; i < 2; ++i) {
      Arm& arm = machine.arm(sides[i]);
      if (ms > 2500) {
        glm::dvec3& target = hands[i].X_WT.translation;
        const double ahead_m = (i == 0 ? 1.0 : -1.0) * (target.y - arm.X_WD().translation.y);
        if (ahead_m < 0.05) target.y += (i == 0 ? 1.0 : -1.0) * 0.0003;  // 0.3 m/s, up to 40 N
      }
      arm.SetHand(hands[i]);
      arm.Send({});
    }
  }
  for (const Side side : sides) EXPECT_EQ(machine.arm(side).safety().state(), SafetyState::kForce);
  EXPECT_LT(machine.arm(Side::kLeft).X_WD().translation.y - machine.arm(Side::kRight).X_WD().translation.y, 0.2);
  EXPECT_LT(machine.least_distance_m(), 0.06);
  EXPECT_GT(machine.least_distance_m(), 0.005);
  EXPECT_LT(glm::length(machine.arm(Side::kLeft).V_WD().linear_m_per_s), 0.05) << "they rest against each other";
}

TEST(Avoidance, AnArmDoesNotReachTheOperator) {
  Machine machine{MachineFigures{}};
  const core::Pose X_WD{{1, 0, 0, 0}, {0.65, -0.2, 0.1}};
  ASSERT_TRUE(machine.Open(Side::kRight, ArmFigures{}, X_WD));
  Hand hand;
  hand.X_WT = X_WD;
  hand.holds_dead_man = true;
  Arm& arm = machine.arm(Side::kRight);
  double least_m = 1e9;
  for (std::int64_t ms = 0; ms < 6000; ++ms) {
    machine.AdvanceTo(ms * 1'000'000);
    if (ms > 2500 && hand.X_WT.translation.x - arm.X_WD().translation.x < 0.05) hand.X_WT.translation.x += 0.0003;
    if (ms > 2500 && hand.X_WT.translation.y < -0.02) hand.X_WT.translation.y += 0.0001;
    arm.SetHand(hand);
    arm.Send({});
    least_m = std::min(least_m, arm.status().least_distance_m);
  }
  EXPECT_GT(least_m, 0.005);
}

}  // namespace
}  // namespace hug
