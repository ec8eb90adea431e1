#include "tracking/dtrack.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <numbers>

namespace tracking {
namespace {

constexpr double kSmall = 1e-12;

DtrackFrame Parsed(std::string_view text) {
  std::vector<std::string> complaints;
  DtrackFrame frame = ParseDtrack(text, &complaints);
  EXPECT_TRUE(complaints.empty()) << complaints.front();
  return frame;
}

// A quarter turn about z takes x to y: the matrix' first column is (0, 1, 0), and columns are sent one after the other.
constexpr const char* kQuarterTurn = "[0 1 0 -1 0 0 0 0 1]";

TEST(Dtrack, ReadsABodyInMetresWithItsMatrixByColumns) {
  const DtrackFrame frame =
      Parsed(std::string("fr 21753\r\nts 39596.024831\r\n6dcal 2\r\n6d 1 [4 0.87][326.848 -187.216 109.503]") +
             kQuarterTurn + " \r\n");
  EXPECT_EQ(frame.number, 21753U);
  EXPECT_EQ(frame.time_s, 39596.024831);
  EXPECT_EQ(frame.num_calibrated, 2);
  ASSERT_EQ(frame.bodies.size(), 1U);
  EXPECT_EQ(frame.bodies[0].id, 4);
  EXPECT_EQ(frame.bodies[0].quality, 0.87);
  EXPECT_NEAR(glm::distance(frame.bodies[0].X_TB.translation, glm::dvec3(0.326848, -0.187216, 0.109503)), 0.0, kSmall);
  EXPECT_NEAR(glm::distance(frame.bodies[0].X_TB.rotate({1, 0, 0}), glm::dvec3(0, 1, 0)), 0.0, kSmall);
}

TEST(Dtrack, ABodyThatIsNotTrackedHasNoPose) {
  const DtrackFrame frame = Parsed("6d 2 [0 -1.000][0 0 0][0 0 0 0 0 0 0 0 0] [1 1.0][1000 0 0][1 0 0 0 1 0 0 0 1]");
  ASSERT_EQ(frame.bodies.size(), 2U);
  EXPECT_FALSE(frame.bodies[0].is_tracked());
  EXPECT_EQ(frame.bodies[0].X_TB.translation, glm::dvec3(0.0));
  EXPECT_TRUE(frame.bodies[1].is_tracked());
  EXPECT_NEAR(frame.bodies[1].X_TB.translation.x, 1.0, kSmall);
}

// Its buttons are valid all the same.
TEST(Dtrack, ReadsAFlystickThatIsNotTracked) {
  const DtrackFrame frame = Parsed("6df2 2 1 [0 -1.000 6 2][0.000 0.000 0.000][0 0 0 0 0 0 0 0 0][5 0.25 -1.00]");
  ASSERT_EQ(frame.flysticks.size(), 1U);
  const TrackedFlystick& stick = frame.flysticks[0];
  EXPECT_FALSE(stick.body.is_tracked());
  EXPECT_EQ(stick.num_buttons, 6);
  EXPECT_EQ(stick.buttons, 5U);
  ASSERT_EQ(stick.num_controllers, 2);
  EXPECT_EQ(stick.controllers[0], 0.25);
  EXPECT_EQ(stick.controllers[1], -1.0);
}

TEST(Dtrack, ReadsAHandWithItsFingers) {
  const std::string finger = std::string("[10 20 30]") + kQuarterTurn + "[7.5 24.0 90 31.0 45 50.0]";
  const DtrackFrame frame = Parsed(std::string("gl 1 [3 1.000 1 3][1 2 3]") + kQuarterTurn + finger + finger + finger);
  ASSERT_EQ(frame.hands.size(), 1U);
  const TrackedHand& hand = frame.hands[0];
  EXPECT_EQ(hand.body.id, 3);
  EXPECT_TRUE(hand.is_right);
  ASSERT_EQ(hand.fingers.size(), 3U);
  EXPECT_NEAR(hand.fingers[2].X_BF.translation.z, 0.030, kSmall);
  EXPECT_NEAR(hand.fingers[2].radius_m, 0.0075, kSmall);
  EXPECT_NEAR(hand.fingers[2].outer_m, 0.024, kSmall);
  EXPECT_NEAR(hand.fingers[2].outer_middle_rad, std::numbers::pi / 2.0, kSmall);
  EXPECT_NEAR(hand.fingers[2].middle_m, 0.031, kSmall);
  EXPECT_NEAR(hand.fingers[2].middle_inner_rad, std::numbers::pi / 4.0, kSmall);
  EXPECT_NEAR(hand.fingers[2].inner_m, 0.050, kSmall);
}

// The manual's examples [ART, DTrack2 user manual, B.2], each in one line. Its angles are another way to say how the
// body of the first stands: R = R_x(phi) R_y(theta) R_z(eta).
TEST(Dtrack, ReadsThePrintedExampleOfABody) {
  const DtrackFrame frame = Parsed(
      "fr 21753\r\nts 39596.024831\r\n"
      "6d 1 [0 1.000][326.848 -187.216 109.503 -160.4704 -3.6963 -7.0913][-0.940508 -0.339238 -0.019025 0.333599 "
      "-0.932599 0.137735 -0.064467 0.123194 0.990286]\r\n");
  EXPECT_EQ(frame.number, 21753U);
  EXPECT_EQ(frame.time_s, 39596.024831);
  ASSERT_EQ(frame.bodies.size(), 1U);
  constexpr double kRad = std::numbers::pi / 180.0;
  const auto about = [](int axis, double angle_deg) {
    glm::dvec3 turn(0.0);
    turn[axis] = angle_deg * kRad;
    return core::QuaternionFromRotationVector(turn);
  };
  const glm::dquat R = about(0, -7.0913) * about(1, -3.6963) * about(2, -160.4704);
  EXPECT_LT(glm::length(core::RotationVector(R * glm::conjugate(frame.bodies[0].X_TB.rotation))), 1e-5);
  EXPECT_LT(glm::distance(frame.bodies[0].X_TB.translation, glm::dvec3(0.326848, -0.187216, 0.109503)), kSmall);
}

TEST(Dtrack, ReadsThePrintedExampleOfHybridBodies) {
  const DtrackFrame frame = Parsed(
      "6di 2 [0 1 2.135][326.848 -187.216 109.503][-0.940508 -0.339238 -0.019025 0.333599 -0.932599 0.137735 -0.064467 "
      "0.123194 0.990286] [1 0 0.000][0.000 0.000 0.000][0.000000 0.000000 0.000000 0.000000 0.000000 0.000000 "
      "0.000000 "
      "0.000000 0.000000]");
  ASSERT_EQ(frame.bodies.size(), 2U);
  EXPECT_TRUE(frame.bodies[0].is_tracked());
  EXPECT_NEAR(frame.bodies[0].X_TB.translation.z, 0.109503, kSmall);
  EXPECT_FALSE(frame.bodies[1].is_tracked());
}

// The first two of its five fingers.
TEST(Dtrack, ReadsThePrintedExampleOfAHand) {
  const DtrackFrame frame = Parsed(
      "gl 1 [0 1.000 1 2][-25.835 -221.498 135.999][0.603034 0.783519 0.149826 -0.729406 0.617627 -0.294114 -0.322981 "
      "0.068077 0.943954][1.4 -42.4 46.7][0.6110 0.3126 0.7273 -0.5609 -0.4773 0.6764 0.5586 -0.8212 -0.1163][11.6 "
      "23.7 "
      "-42.9 39.6 -22.6 59.4][36.4 -12.8 56.0][-0.4019 -0.0429 0.9147 -0.1640 -0.9794 -0.1180 0.9009 -0.1975 "
      "0.3865][9.2 "
      "18.2 -24.5 27.6 -73.2 46.0]");
  ASSERT_EQ(frame.hands.size(), 1U);
  EXPECT_TRUE(frame.hands[0].is_right);
  ASSERT_EQ(frame.hands[0].fingers.size(), 2U);
  const TrackedFinger& index = frame.hands[0].fingers[1];
  EXPECT_LT(glm::distance(index.X_BF.translation, glm::dvec3(0.0364, -0.0128, 0.0560)), kSmall);
  EXPECT_LT(glm::distance(index.X_BF.rotate({1, 0, 0}), glm::dvec3(-0.4019, -0.0429, 0.9147)), 1e-4);
  EXPECT_NEAR(index.radius_m, 0.0092, kSmall);
  EXPECT_NEAR(index.middle_inner_rad, -73.2 * std::numbers::pi / 180.0, kSmall);
}

// Flysticks in the old format, and measurement tools: nobody here has a use for them.
TEST(Dtrack, PassesOverThePrintedExamplesOfOldFlysticksAndMeasurementTools) {
  const DtrackFrame frame = Parsed(
      "6df 1 [0 1.000 2][261.103 116.520 41.085 19.6522 -57.3530 116.5992][-0.241543 0.968868 -0.054332 -0.482366 "
      "-0.168461 -0.859619 -0.842010 -0.181427 0.508039]\r\n"
      "6dmt2 1 1 [0 1.000 4 2.000][326.848 -187.216 109.503][0.911812 -0.038421 0.408806 0.095040 0.988324 -0.119094 "
      "-0.399457 0.147444 0.904817][0][8.178e-04 9.166e-04 1.084e-03 4.463e-02 9.025e-03 1.286e-02]\r\n"
      "6dmtr 1 1 [0 1.000][-485.245 -67.217 -38.328][0.681257 -0.315034 0.660790 -0.477531 -0.875410 0.074967 0.554845 "
      "-0.366620 -0.746817]\r\n"
      "6dmt 1 [0 1.000 0][326.848 -187.216 109.503][0.911812 -0.038421 0.408806 0.095040 0.988324 -0.119094 -0.399457 "
      "0.147444 0.904817]\r\nfr 3\r\n");
  EXPECT_EQ(frame.number, 3U);
  EXPECT_TRUE(frame.bodies.empty());
  EXPECT_TRUE(frame.flysticks.empty());
}

TEST(Dtrack, PassesOverWhatItDoesNotKnowAndKeepsTheRest) {
  const DtrackFrame frame = Parsed("fr 1\n6dj 1 1 [0 1][0 1.0][1 2 3][1 2 3]\nnew stuff [\n6dcal 7\n");
  EXPECT_EQ(frame.number, 1U);
  EXPECT_EQ(frame.num_calibrated, 7);
}

struct Broken {
  const char* text;
  const char* complaint;
};
class DtrackBroken : public ::testing::TestWithParam<Broken> {};

TEST_P(DtrackBroken, LineIsNamedAndWhatWasBeforeItIsKept) {
  std::vector<std::string> complaints;
  const DtrackFrame frame = ParseDtrack(std::string("fr 9\r\n") + GetParam().text, &complaints);
  EXPECT_EQ(frame.number, 9U);
  EXPECT_TRUE(frame.bodies.empty());
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_EQ(complaints[0], GetParam().complaint);
}

INSTANTIATE_TEST_SUITE_P(
    Each, DtrackBroken,
    ::testing::Values(Broken{"6d 1 [0 1.0][1 2 3][1 0 0 0 1 0", "line 2 (6d): a block is cut off"},
                      Broken{"6d 1", "line 2 (6d): a block is cut off"},
                      Broken{"6d", "line 2 (6d): a number is missing or is none"},
                      Broken{"6d -1", "line 2 (6d): a count is not a whole number from 0 to 256"},
                      Broken{"6d 99999 ", "line 2 (6d): a count is not a whole number from 0 to 256"},
                      Broken{"6d 1 [0 1.0][1 2][1 0 0 0 1 0 0 0 1]",
                             "line 2 (6d): a block has too few numbers, or one that is none"},
                      Broken{"6d 1 [0 1.0][nan 2 3][1 0 0 0 1 0 0 0 1]",
                             "line 2 (6d): a block has too few numbers, or one that is none"},
                      Broken{"6d 1 [0 1.0][1 2 3][1 0 0 0 1 0 0 0 -1]", "line 2 (6d): a matrix is no rotation"},
                      Broken{"6d 1 [0 1.0][1 2 3][2 0 0 0 1 0 0 0 1]", "line 2 (6d): a matrix is no rotation"},
                      Broken{"6d 1 [0.5 1.0][1 2 3][1 0 0 0 1 0 0 0 1]", "line 2 (6d): an id is no count"}));

// A decimal comma of the program's locale changes nothing.
TEST(Dtrack, IsReadTheSameInEveryLocale) {
  const char* german = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  const DtrackFrame frame = Parsed("ts 1.5");
  std::setlocale(LC_NUMERIC, "C");
  EXPECT_EQ(frame.time_s, 1.5) << (german != nullptr ? german : "there is no German locale here");
}

}  // namespace
}  // namespace tracking
