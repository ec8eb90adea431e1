#include "tracking/finger_angles.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "scene/load_scenario.hpp"
#include "tracking/glove.hpp"

namespace tracking {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(Glove, ReadsTheHandThatIsAskedFor) {
  const char* const line =
      "glove 2 [0 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3] [3 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1.0 1.1 1.2 1.3 1.4 -1.5]\r\n";
  const auto angles_rad = ParseGlove(line, 3);
  ASSERT_TRUE(angles_rad);
  EXPECT_EQ((*angles_rad)[0], 0.1);
  EXPECT_EQ((*angles_rad)[13], 1.4);
  EXPECT_EQ((*angles_rad)[14], -1.5);
  EXPECT_FALSE(ParseGlove(line, 2));
}

TEST(Glove, RefusesWhatIsCutOffOrNoAngle) {
  EXPECT_FALSE(ParseGlove("glove 1 [0 1 1 1 1 1 1 1 1 1 1 1 1 1 1]", 0));  // fourteen
  EXPECT_FALSE(ParseGlove("glove 1 [0 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1", 0));
  EXPECT_FALSE(ParseGlove("glove 1 [0 1 1 1 1 1 1 1 1 1 1 1 1 1 1 4]", 0));  // beyond half a turn
  EXPECT_FALSE(ParseGlove("glove 1 [0 1 1 1 1 1 1 1 1 1 1 1 1 1 1 nan]", 0));
  EXPECT_FALSE(ParseGlove("pinch 1 [0 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1]", 0));
}

// A finger whose tip points along x of the hand, turned by `flexion` towards its palm, -z.
TrackedFinger FingerAt(double flexion_rad, double outer_rad, double middle_rad) {
  TrackedFinger finger;
  finger.X_BF.rotation = core::QuaternionFromRotationVector({0.0, flexion_rad, 0.0});
  finger.X_BF.translation = {0.0, 0.05, -0.05};
  finger.outer_middle_rad = outer_rad;
  finger.middle_inner_rad = middle_rad;
  return finger;
}

TEST(FingerAngles, OfATrackedHandAddUpToWhereTheTipPoints) {
  TrackedHand hand;
  hand.fingers = {FingerAt(0.0, 0.1, 0.2), FingerAt(90 * kDegree, 30 * kDegree, 20 * kDegree),
                  FingerAt(-10 * kDegree, 0.0, 0.0)};
  const auto angles_rad = AnglesOf(hand);
  ASSERT_TRUE(angles_rad);
  EXPECT_NEAR((*angles_rad)[0], 45 * kDegree, 1e-9);
  EXPECT_EQ((*angles_rad)[1], 0.2);
  EXPECT_EQ((*angles_rad)[2], 0.1);
  EXPECT_NEAR((*angles_rad)[3], 40 * kDegree, 1e-9);
  EXPECT_NEAR((*angles_rad)[4], 20 * kDegree, 1e-9);
  EXPECT_NEAR((*angles_rad)[5], 30 * kDegree, 1e-9);
  EXPECT_NEAR((*angles_rad)[6], -10 * kDegree, 1e-9);
  EXPECT_EQ((*angles_rad)[12], (*angles_rad)[6]);  // three fingers: the little one goes with the middle one
  hand.fingers.resize(1);
  EXPECT_FALSE(AnglesOf(hand));
}

// Where the hand's own file puts the joints, by their poses alone.
class HandFile : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto loaded =
        scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/five_fingers" / GetParam());
    ASSERT_TRUE(loaded) << scene::Format(loaded.error().front());
    scenario_ = *loaded;
  }

  // In the palm's frame, of a point of a finger's link, the joints turned to these angles.
  [[nodiscard]] glm::dvec3 Place(const FingerAngles& angles_rad, std::size_t link, const glm::dvec3& p_L) const {
    const auto& m = scenario_.mechanisms.at(link);
    const core::Pose turn{core::QuaternionFromRotationVector({0.0, 0.0, angles_rad.at(link)}), glm::dvec3(0.0)};
    const glm::dvec3 p_P = m.X_PJ * (turn * (m.X_CJ.inverse() * p_L));
    return link % 3 == 0 ? p_P : Place(angles_rad, link - 1, p_P);
  }

  scene::Scenario scenario_;
};

TEST_P(HandFile, HasFiveFingersOfThreeJoints) {
  ASSERT_EQ(scenario_.mechanisms.size(), kNumFingerAngles);
  for (std::size_t i = 0; i < kNumFingerAngles; ++i)
    EXPECT_EQ(scenario_.mechanisms[i].finger_joint, static_cast<int>(i));
}

TEST_P(HandFile, StraightFingersPointAwayFromThePalmAndFlexTowardsTheThumb) {
  FingerAngles angles_rad{};
  for (const std::size_t finger : {1U, 2U, 3U, 4U}) {
    const glm::dvec3 root = Place(angles_rad, 3 * finger, glm::dvec3(0.0));
    const glm::dvec3 tip = Place(angles_rad, 3 * finger + 2, {0.026, 0.0, 0.0});
    EXPECT_NEAR(glm::distance(tip - root, glm::dvec3(0.0, 0.0, -0.101)), 0.0, 1e-6);
    for (std::size_t joint = 0; joint < 3; ++joint) {
      FingerAngles bent{};
      bent[3 * finger + joint] = 0.1;
      EXPECT_LT(Place(bent, 3 * finger + 2, {0.026, 0.0, 0.0}).x, tip.x - 0.002);
    }
  }
}

TEST_P(HandFile, TheThumbTurnsFromBesideThePalmToBeforeTheFingers) {
  const bool is_left = scenario_.devices[0].role == "left";
  FingerAngles angles_rad{};
  const glm::dvec3 beside = Place(angles_rad, 2, {0.038, 0.0, 0.0});
  EXPECT_GT(is_left ? -beside.y : beside.y, 0.035);
  angles_rad[0] = 63.7 * kDegree;
  const glm::dvec3 before = Place(angles_rad, 2, {0.038, 0.0, 0.0});
  EXPECT_NEAR(before.y, 0.0, 1e-3);
  EXPECT_NEAR(before.x, -0.018, 1e-3);
  angles_rad[1] = 0.1;
  EXPECT_GT(Place(angles_rad, 2, {0.038, 0.0, 0.0}).x, before.x + 0.005);
}

// The outer links are parallel to the plane between thumb and fingers, and half of the opening and their radius away.
TEST_P(HandFile, GraspAnglesPutThePadsThatFarApart) {
  for (const double opening_m : {0.005, 0.02, 0.05, 0.08}) {
    const FingerAngles angles_rad = GraspAngles(opening_m);
    for (const double along_m : {0.0, 0.02}) {
      EXPECT_NEAR(Place(angles_rad, 8, {along_m, 0.0, 0.0}).x - 0.008, 0.5 * opening_m, 1e-6) << opening_m;
      EXPECT_NEAR(Place(angles_rad, 2, {along_m, 0.0, 0.0}).x + 0.009, -0.5 * opening_m, 1e-3) << opening_m;
    }
    for (std::size_t i = 0; i < kNumFingerAngles; ++i) {
      EXPECT_GE(angles_rad[i], scenario_.mechanisms[i].lower);
      EXPECT_LE(angles_rad[i], scenario_.mechanisms[i].upper);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, HandFile, ::testing::Values("scenario.xml", "left.xml"));

}  // namespace
}  // namespace tracking
