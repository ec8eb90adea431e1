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
