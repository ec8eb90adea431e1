#include "nodes/device_bridge/operator/pointer_hand.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

scene::Scenario OneHand() {
  scene::Scenario scenario;
  scenario.force_cap_N = 40.0;
  scenario.devices.resize(1);
  scenario.devices[0].role = "right";
  return scenario;
}

// A viewer, and a device that goes where the hand's target is, unless it is blocked.
struct PointerBench {
  scene::Scenario scenario = OneHand();
  PointerHand pointer{scenario};
  Inputs inputs;
  core::FixedVector<FeltForce, kMaxRoles> felt;
  core::FixedVector<DeviceReading, kMaxRoles> readings;
  bool is_blocked = false;

  PointerBench() {
    inputs.now_ns = 1'000'000'000;
    inputs.hands.push_back({});
    felt.push_back({});
    readings.push_back({});
  }
  core::HandInput& input() { return inputs.hands[0]; }
  void Send() { ++input().header.sequence; }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      inputs.now_ns += core::kTick_ns;
      if (i % 30 == 0) Send();
      pointer.Step(inputs, felt, readings, core::kTick_s);
      if (!is_blocked) readings[0].X_WD = pointer.target(0).X_WT;
    }
  }
};

TEST(PointerHand, FollowsTheSumsOfTheViewerWhileItIsHeld) {
  PointerBench bench;
  bench.input().is_held = true;
  bench.Run(1);
  for (int i = 1; i <= 10; ++i) {
    bench.input().moved_W_m = {0.002 * i, 0, 0};
    bench.input().turned_W_rad = {0, 0, 0.01 * i};
    bench.Run(40);
  }
  bench.Run(300);
  EXPECT_NEAR(bench.pointer.target(0).X_WT.translation.x, 0.02, 1e-4);
  EXPECT_NEAR(core::RotationVector(bench.pointer.target(0).X_WT.rotation).z, 0.1, 1e-3);
  EXPECT_LT(glm::length(bench.pointer.target(0).V_WT.linear_m_per_s), 1e-3);
}

TEST(PointerHand, MotionWithTheClutchOpenAndMessagesThatWereLostCountAsTheyShould) {
  PointerBench bench;
  bench.input().is_held = true;
  bench.Run(1);
  bench.input().is_held = false;
  bench.input().moved_W_m = {0.5, 0, 0};
  bench.Run(100);
  bench.input().is_held = true;
  bench.Run(100);
  EXPECT_NEAR(bench.pointer.target(0).X_WT.translation.x, 0.0, 1e-9);
  bench.input().header.sequence += 20;  // messages were lost; the sum has what they said
  bench.input().moved_W_m = {0.53, 0, 0};
  bench.Run(400);
  EXPECT_NEAR(bench.pointer.target(0).X_WT.translation.x, 0.03, 1e-4);
}

TEST(PointerHand, NeverPullsTheSpringBeyondItsShareOfTheForceCap) {
  PointerBench bench;
  bench.is_blocked = true;
  bench.input().is_held = true;
  bench.Run(1);
  bench.input().moved_W_m = {2.0, 0, 0};
  bench.input().turned_W_rad = {0, 3.0, 0};
  bench.Run(3000);
  const double lead_m = glm::length(bench.pointer.target(0).X_WT.translation);
  EXPECT_LE(lead_m * bench.scenario.devices[0].hand_stiffness_N_per_m, 0.85 * 40.0 + 1e-6);
  EXPECT_GT(lead_m, 0.04);
  EXPECT_LE(glm::length(core::RotationVector(bench.pointer.target(0).X_WT.rotation)), 0.35 + 1e-6);
}

TEST(PointerHand, WhereTheForceIsOffNobodyPresses) {
  PointerBench bench;
  bench.is_blocked = true;
  bench.input().is_held = true;
  bench.Run(1);
  bench.input().moved_W_m = {0.1, 0, 0};
  bench.Run(100);
  bench.felt[0].is_off = true;
  bench.Run(1);
  EXPECT_EQ(bench.pointer.target(0).X_WT.translation, glm::dvec3(0.0));
}

TEST(PointerHand, JawsCloseAtTheirSpeedAndAViewerThatFallsSilentLetsGo) {
  PointerBench bench;
  bench.input().is_held = true;
  bench.input().wants_guidance = true;
  bench.Run(1);
  EXPECT_TRUE(bench.pointer.wants_guidance());
  bench.input().closing = 1.0;
  bench.Run(100);
  EXPECT_NEAR(bench.pointer.target(0).opening_m, 0.06 - 0.015, 0.002);
  bench.Run(500);
  EXPECT_EQ(bench.pointer.target(0).opening_m, 0.0);
  for (int i = 0; i < 400; ++i) {
    bench.inputs.now_ns += core::kTick_ns;  // the same message again and again
    bench.pointer.Step(bench.inputs, bench.felt, bench.readings, core::kTick_s);
  }
  EXPECT_FALSE(bench.pointer.wants_guidance());
}

TEST(PointerHand, NumbersThatAreNotFiniteAreLeftOut) {
  PointerBench bench;
  bench.input().is_held = true;
  bench.Run(1);
  bench.input().moved_W_m = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
  bench.Run(100);
  EXPECT_EQ(bench.pointer.target(0).X_WT.translation, glm::dvec3(0.0));
}

}  // namespace
}  // namespace device_bridge
