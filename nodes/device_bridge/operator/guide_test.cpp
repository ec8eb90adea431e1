#include "nodes/device_bridge/operator/guide.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

using Kind = core::GuideKind;

// A hand that is wherever a person has put it, in a scene of one part and a latch.
struct GuidedHand {
  scene::Scenario scenario;
  OperatorScript script;
  std::unique_ptr<Guide> guide;
  core::PhysicsState physics;
  core::LogicStatus logic;
  Inputs inputs;
  core::FixedVector<FeltForce, kMaxRoles> felt;
  core::FixedVector<DeviceReading, kMaxRoles> readings;

  explicit GuidedHand(const std::string& text) {
    scenario.objects.resize(2);
    scenario.objects[0].name = "thing";
    scenario.objects[0].owner = scene::Owner::kPhysics;
    scenario.objects[1].name = "place";
    scenario.objects[1].owner = scene::Owner::kFixed;
    scenario.mechanisms.resize(1);
    scenario.mechanisms[0].name = "latch";
    scenario.mechanisms[0].kind = scene::MechanismKind::kSnap;
    scenario.devices.resize(1);
    scenario.devices[0].role = "right";
    auto parsed = ParseOperatorScript(text, "script", scenario, {});
    EXPECT_TRUE(parsed.diagnostics.empty());
    script = std::move(parsed.script);
    guide = std::make_unique<Guide>(scenario, script);
    physics.header.sequence = 1;
    physics.bodies.push_back({0, core::Pose{{1, 0, 0, 0}, {0.3, 0, 0}}, core::Twist{}});
    physics.mechanisms.push_back({0, 0, 0.0, 0.0});
    logic.step = "a";
    inputs.physics = &physics;
    inputs.logic = &logic;
    inputs.grasped_objects.push_back(core::kNoObject);
    felt.push_back({});
    felt[0].opening_m = 0.05;
    readings.push_back({});
  }
  glm::dvec3& hand() { return readings[0].X_WD.translation; }
  const Tip& Look(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      inputs.now_ns += core::kTick_ns;
      guide->Step(inputs, felt, readings);
    }
    return guide->tip(0);
  }
};

constexpr const char* kFetch =
    "step a\n"
    "grip 0.05\n"
    "reach thing offset 0 0 0.06\n"
    "reach thing within 0.002\n"
    "grip 0.002 force 25\n"
    "wait until held thing\n"
    "carry thing to place offset 0 0 0.1\n"
    "push 0 0 -1 by 0.05 until engaged latch\n";

TEST(Guide, LeadsThroughTheLinesByWhatIsSeen) {
  GuidedHand bench(kFetch);
  Tip tip = bench.Look();
  EXPECT_EQ(tip.kind, Kind::kMove);
  EXPECT_LT(glm::distance(tip.way_W_m, glm::dvec3(0.3, 0, 0.06)), 1e-9);
  bench.hand() = {0.3, 0.005, 0.06};  // on the way, near is enough
  EXPECT_LT(glm::distance(bench.Look().way_W_m, glm::dvec3(0, -0.005, -0.06)), 1e-9);
  bench.hand() = {0.3, 0, 0.001};
  EXPECT_EQ(bench.Look().kind, Kind::kClose);
  bench.inputs.grasped_objects[0] = 0;
  EXPECT_LT(glm::distance(bench.Look().way_W_m, glm::dvec3(-0.3, 0, 0.1)), 1e-9) << "the part, not the hand";
}

TEST(Guide, DoesNotSendWhoHoldsThePartToFetchIt) {
  GuidedHand bench(kFetch);
  bench.inputs.grasped_objects[0] = 0;
  EXPECT_LT(glm::distance(bench.Look().way_W_m, glm::dvec3(-0.3, 0, 0.1)), 1e-9);
}

TEST(Guide, APushGoesOnUntilItHasDoneWhatItIsFor) {
  GuidedHand bench("step a\npush 0 0 -1 by 0.05 until engaged latch\n");
  EXPECT_LT(glm::distance(bench.Look().way_W_m, glm::dvec3(0, 0, -0.05)), 1e-9);
  bench.hand() = {0.002, 0, -0.05};
  EXPECT_LT(glm::distance(bench.Look().way_W_m, glm::dvec3(-0.002, 0, -0.01)), 1e-9) << "back to its line, and on";
  bench.physics.mechanisms[0].state = 1;
  EXPECT_EQ(bench.Look().kind, Kind::kNone);
}

TEST(Guide, JawsOpenHoweverFarAndAnEmptyHandIsNoMarkOfWhatWasDone) {
  GuidedHand bench("step a\ngrip 0.05\nwait until released\nreach thing\ngrip 0.0\nwait until released\n");
  bench.felt[0].opening_m = 0.01;
  EXPECT_EQ(bench.Look().kind, Kind::kOpen);
  bench.felt[0].opening_m = 0.09;
  EXPECT_EQ(bench.Look().kind, Kind::kMove);
  bench.hand() = {0.3, 0, 0};
  EXPECT_EQ(bench.Look().kind, Kind::kClose);
}

TEST(Guide, BeginsAgainWhereAllIsDoneAndTheStepIsNot) {
  GuidedHand bench("step a\nreach thing\n");
  bench.hand() = {0.3, 0, 0};
  EXPECT_EQ(bench.Look().kind, Kind::kNone);
  bench.hand() = {0.2, 0, 0};
  EXPECT_EQ(bench.Look(3900).kind, Kind::kNone);
  EXPECT_EQ(bench.Look(200).kind, Kind::kMove);
  bench.logic.is_final = true;
  EXPECT_EQ(bench.Look().kind, Kind::kNone);
}

}  // namespace
}  // namespace device_bridge
