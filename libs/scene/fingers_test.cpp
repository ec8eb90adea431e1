#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "scene/load_scenario.hpp"

namespace scene {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/five_fingers";

Scenario Load(const char* file) {
  const auto loaded = LoadScenario(kFolder / file);
  EXPECT_TRUE(loaded) << Format(loaded.error().front());
  return loaded.value_or(Scenario{});
}

TEST(Fingers, AreLinksThatPhysicsMovesOnThePalm) {
  const Scenario s = Load("scenario.xml");
  ASSERT_EQ(s.mechanisms.size(), static_cast<std::size_t>(kFingerJoints));
  for (int i = 0; i < kFingerJoints; ++i) {
    const Mechanism& m = s.mechanisms[static_cast<std::size_t>(i)];
    EXPECT_EQ(m.kind, MechanismKind::kHinge);
    EXPECT_EQ(m.finger_joint, i);
    EXPECT_EQ(m.finger_role, 0);
    EXPECT_GT(m.motor_limit, 0.0);
    EXPECT_LT(m.lower, m.upper);
    const Object& link = s.objects[static_cast<std::size_t>(m.child)];
    ASSERT_TRUE(link.finger_link) << link.name;
    EXPECT_EQ(link.owner, Owner::kPhysics);
    EXPECT_EQ(link.finger_link->finger, i / kJointsPerFinger);
    EXPECT_EQ(link.group, s.objects[static_cast<std::size_t>(s.devices[0].palm)].group);
    EXPECT_EQ(s.objects[static_cast<std::size_t>(m.parent)].owner,
              i % kJointsPerFinger == 0 ? Owner::kHand : Owner::kPhysics);
  }
  EXPECT_EQ(s.objects[static_cast<std::size_t>(s.mechanisms[3].child)].name, "right_index_1");
}

TEST(Fingers, TouchInPhysicsNodeWithTheirPads) {
  const Scenario s = Load("scenario.xml");
  int num_pads = 0;
  for (const Pair& pair : s.pairs) {
    const Object& sampled = s.objects[pair.sampled];
    if (!sampled.finger_link) continue;
    ++num_pads;
    EXPECT_EQ(pair.owner, PairOwner::kPhysics);
    EXPECT_EQ(pair.friction, 0.8);
    EXPECT_EQ(pair.stiffness_N_per_m, 8000.0);
    EXPECT_FALSE(s.objects[pair.field].finger_link);
  }
  EXPECT_EQ(num_pads, 2 * 14);  // the metacarpal touches nothing; the block and the plate
}

// In the plane y = 0 of the palm, as wholes: where each link's axis stands, and which way it flexes.
TEST(Fingers, OfALeftHandAreTheMirrorImage) {
  const Scenario right = Load("scenario.xml");
  const Scenario left = Load("left.xml");
  const auto link = [](const Scenario& s, int i) {
    const Mechanism& m = s.mechanisms[static_cast<std::size_t>(i)];
    return s.devices[0].X_WD_start.inverse() * s.objects[static_cast<std::size_t>(m.child)].X_WO;
  };
  const glm::dvec3 mirror(1.0, -1.0, 1.0);
  for (int i = 0; i < kFingerJoints; ++i) {
    const core::Pose a = link(right, i);
    const core::Pose b = link(left, i);
    EXPECT_LT(glm::distance(mirror * a.translation, b.translation), 1e-9) << i;
    EXPECT_LT(glm::distance(mirror * a.rotate({1, 0, 0}), b.rotate({1, 0, 0})), 1e-6) << i;  // along the link
    EXPECT_LT(glm::distance(mirror * a.rotate({0, 1, 0}), b.rotate({0, 1, 0})), 1e-6) << i;  // the way it flexes
    EXPECT_LT(glm::distance(-mirror * a.rotate({0, 0, 1}), b.rotate({0, 0, 1})), 1e-6) << i;
    EXPECT_EQ(right.mechanisms[static_cast<std::size_t>(i)].lower, left.mechanisms[static_cast<std::size_t>(i)].lower);
  }
}

TEST(Fingers, WithoutAHandToBeOnAreRefused) {
  std::ifstream in(kFolder / "scenario.xml");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::string before = "<fingers role=\"right\"";
  text.replace(text.find(before), before.size(), "<fingers role=\"third\"");
  const auto folder = std::filesystem::path(testing::TempDir()) / "fingers_of_nobody";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scenario.xml") << text;
  const auto loaded = LoadScenario(folder / "scenario.xml");
  ASSERT_FALSE(loaded);
  EXPECT_TRUE(std::any_of(loaded.error().begin(), loaded.error().end(), [](const Diagnostic& d) {
    return d.what == "fingers of role 'third': there is no device with that role" && d.where.line > 1;
  }));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace scene
