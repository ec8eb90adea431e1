// The golden recordings (tests/golden/README.md), replayed node by node.

#include "tests/golden.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "bus/log/mcap_reader.hpp"
#include "replay/platform.hpp"

namespace system_tests {
namespace {

// Bit for bit where libm and compiler are those of the recording; else within the tolerance, with a note in the output.
void ExpectEqual(const std::string& node, const std::filesystem::path& file = GoldenFile(),
                 const std::string& scenario = "module_replacement/paper.xml") {
  const lockstep::RecordedNode recorded = GoldenNode(node, file);
  lockstep::StepsOptions options;
  const bool has_same_bits = replay::GivesSameBits(recorded.about, replay::DescribePlatform());
  if (!has_same_bits) {
    auto tolerance = replay::Tolerance::Read(GoldenFolder() / "module_replacement.tolerance");
    ASSERT_TRUE(tolerance) << tolerance.error().detail;
    options.tolerance = *tolerance;
    std::printf("recorded with another libm or compiler: compared within the tolerance, not bit for bit\n");
  }
  const auto outcome = lockstep::ReplaySteps(file, recorded, Load(scenario), options);
  ASSERT_TRUE(outcome) << outcome.error().detail;
  std::printf("%s", lockstep::Describe(recorded, *outcome).c_str());
  EXPECT_GE(outcome->num_steps, 80U);
  EXPECT_EQ(outcome->num_different, 0U) << lockstep::Describe(recorded, *outcome);
  if (has_same_bits) {
    EXPECT_EQ(outcome->num_inexact, 0U);
  }
}

TEST(Golden, LogicNodeDoesAsRecorded) {
  ExpectEqual("logic_node");
}
TEST(Golden, PhysicsNodeDoesAsRecorded) {
  ExpectEqual("physics_node");
}
TEST(Golden, HapticNodeDoesAsRecorded) {
  ExpectEqual("haptic_node");
}

TEST(GoldenDefault, LogicNodeDoesAsRecorded) {
  ExpectEqual("logic_node", GoldenFileOfTheDefault(), "module_replacement");
}
TEST(GoldenDefault, PhysicsNodeDoesAsRecorded) {
  ExpectEqual("physics_node", GoldenFileOfTheDefault(), "module_replacement");
}
TEST(GoldenDefault, HapticNodeDoesAsRecorded) {
  ExpectEqual("haptic_node", GoldenFileOfTheDefault(), "module_replacement");
}

TEST(Golden, IsSmallAndStatesWhereItsBitsComeFrom) {
  EXPECT_LT(std::filesystem::file_size(GoldenFile()), 5'000'000U);
  for (const char* node : {"logic_node", "physics_node", "haptic_node"}) {
    const bus::log::TextMap about = GoldenNode(node).about;
    for (const char* key : {"simd", "libm", "compiler", "denormals", "scenario", "scenario_digest"}) {
      EXPECT_TRUE(about.contains(key)) << node << " " << key;
    }
  }
}

// A stretch without contact would test little.
TEST(Golden, HoldsAContactThatTheHandFeels) {
  bool is_touching = false;
  const lockstep::RecordedNode recorded = GoldenNode("haptic_node");
  auto node = lockstep::ReplayedNode::Create(recorded, Load("module_replacement/paper.xml"), {});
  ASSERT_TRUE(node) << node.error().detail;
  const auto read = bus::log::ReadMcap(GoldenFile(), [&](const bus::log::Channel& channel, const bus::log::Message& m) {
    if (channel.topic != "replay/haptic_node/step" || is_touching) return;
    ASSERT_TRUE((*node)->Read(m.data));
    for (const replay::Leaf& leaf : (*node)->RecordedOutputs()) {
      is_touching |= leaf.path == "commands[0].F_Do_W.force_N.z" && std::abs(leaf.number) > 1.0;
    }
  });
  ASSERT_TRUE(read);
  EXPECT_TRUE(is_touching);
}

// With a constant changed by a thousandth the replay must differ, and the report must name the field that does.
lockstep::StepsOutcome WithScenario(const std::string& node, const scene::Scenario& scenario,
                                    const lockstep::StepsOptions& options = {}) {
  const auto outcome = lockstep::ReplaySteps(GoldenFile(), GoldenNode(node), scenario, options);
  EXPECT_TRUE(outcome) << outcome.error().detail;
  return outcome.value_or(lockstep::StepsOutcome{});
}

TEST(Golden, AHeavierHandleIsCaughtAndNamed) {
  scene::Scenario scenario = Load("module_replacement/paper.xml");
  const int handle = scenario.FindObject("handle");
  ASSERT_GE(handle, 0);
  scenario.objects[static_cast<std::size_t>(handle)].mass_kg *= 1.001;
  scenario.objects[static_cast<std::size_t>(handle)].density_kg_per_m3 *= 1.001;
  const lockstep::StepsOutcome outcome = WithScenario("physics_node", scenario);
  EXPECT_GT(outcome.num_different, 10U);
  EXPECT_TRUE(outcome.name.starts_with("physics/")) << outcome.name;
  EXPECT_FALSE(outcome.first.path.empty());
  EXPECT_FALSE(outcome.growth.empty());
}

// Mechanism parameters can change during a run, so the checkpoint holds them: they are changed there.
TEST(Golden, AChangedSpringOfTheSnapIsCaughtAndNamed) {
  const scene::Scenario scenario = Load("module_replacement/paper.xml");
  const int snap = scenario.FindMechanism("hook_old");
  ASSERT_GE(snap, 0);
  lockstep::StepsOptions options;
  options.mutations = {
      {"hook_old.stiffness_N_per_m", 1.001 * scenario.mechanisms[static_cast<std::size_t>(snap)].stiffness_N_per_m}};
  const lockstep::StepsOutcome outcome = WithScenario("physics_node", scenario, options);
  EXPECT_GT(outcome.num_different, 10U);
  EXPECT_TRUE(outcome.name.starts_with("physics/state:bodies[")) << outcome.name;
  EXPECT_EQ(outcome.thing, "handle");
  EXPECT_GE(outcome.growth.size(), 2U);
}

TEST(Golden, AChangedSpringOfTheCouplingIsCaughtAndNamed) {
  scene::Scenario scenario = Load("module_replacement/paper.xml");
  scenario.coupling.stiffness_N_per_m *= 1.001;
  const lockstep::StepsOutcome outcome = WithScenario("haptic_node", scenario);
  EXPECT_GT(outcome.num_different, 10U);
  EXPECT_TRUE(outcome.name.starts_with("contacts/haptic_node/")) << outcome.name;
  EXPECT_NE(outcome.name.find("stiffness_N_per_m"), std::string::npos) << outcome.name;
}

TEST(Golden, AParameterChangedInTheReplayIsCaught) {
  lockstep::StepsOptions options;
  options.mutations = {{"force_cap_N", 0.5}};
  const lockstep::StepsOutcome outcome = WithScenario("haptic_node", Load("module_replacement/paper.xml"), options);
  EXPECT_GT(outcome.num_different, 10U);
  EXPECT_TRUE(outcome.name.starts_with("device/right/command:F_Do_W.force_N")) << outcome.name;
}

TEST(Golden, ReplaySpeedChangesNoResult) {
  for (const char* node : {"logic_node", "physics_node"}) {
    lockstep::StepsOptions options;
    const std::uint64_t digest = WithScenario(node, Load("module_replacement/paper.xml"), options).digest;
    options.speed = 10.0;
    EXPECT_EQ(WithScenario(node, Load("module_replacement/paper.xml"), options).digest, digest) << node;
  }
}

TEST(Golden, StepsOfAnotherVersionAreRefusedByName) {
  lockstep::RecordedNode recorded = GoldenNode("logic_node");
  recorded.fields += "status.mood f64\n";
  const auto outcome = lockstep::ReplaySteps(GoldenFile(), recorded, Load("module_replacement/paper.xml"), {});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, core::ErrorCode::kUnsupported);
  EXPECT_NE(outcome.error().detail.find("logic_node"), std::string::npos) << outcome.error().detail;
}

TEST(Golden, StepsWithoutTheirCheckpointAreRefused) {
  lockstep::RecordedNode recorded = GoldenNode("physics_node");
  recorded.checkpoint.clear();
  const auto outcome = lockstep::ReplaySteps(GoldenFile(), recorded, Load("module_replacement/paper.xml"), {});
  ASSERT_FALSE(outcome);
  EXPECT_NE(outcome.error().detail.find("stands at tick 0"), std::string::npos) << outcome.error().detail;
}

TEST(Golden, ACheckpointOfAnotherSceneIsRefused) {
  const auto outcome = lockstep::ReplaySteps(GoldenFile(), GoldenNode("physics_node"), Load("touch"), {});
  ASSERT_FALSE(outcome);
}

}  // namespace
}  // namespace system_tests
