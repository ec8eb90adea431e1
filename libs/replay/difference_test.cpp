#include "replay/difference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "replay/fields.hpp"

namespace replay {
namespace {

std::vector<Leaf> LeavesOf(core::Reaction reaction) {
  Leaves leaves;
  Field(leaves, "reactions", reaction);
  return leaves.all();
}

std::vector<FieldDifference> Between(const core::Reaction& a, const core::Reaction& b,
                                     const std::string& tolerance = "") {
  const auto parsed = Tolerance::Parse(tolerance, "tolerance.txt");
  EXPECT_TRUE(parsed) << parsed.error().detail;
  return Compare(LeavesOf(a), LeavesOf(b), *parsed, [](const std::string& path) { return path; });
}

TEST(Compare, NamesTheFieldsThatDifferInTheirOrder) {
  core::Reaction a, b;
  b.F_Do_W.force_N.z = 2.5;
  b.grasped_object = 3;
  EXPECT_TRUE(Between(a, a).empty());
  const auto differences = Between(a, b);
  ASSERT_EQ(differences.size(), 2U);
  EXPECT_EQ(differences[0].path, "reactions.grasped_object");
  EXPECT_EQ(differences[0].expected, "65535");
  EXPECT_EQ(differences[0].got, "3");
  EXPECT_EQ(differences[1].path, "reactions.F_Do_W.force_N.z");
  EXPECT_DOUBLE_EQ(differences[1].distance, 2.5);
}

TEST(Compare, IsExactToTheLastBit) {
  core::Reaction a, b;
  a.F_Do_W.force_N.x = 1.0;
  b.F_Do_W.force_N.x = std::nextafter(1.0, 2.0);
  ASSERT_EQ(Between(a, b).size(), 1U);
  EXPECT_EQ(Between(a, b)[0].got, "1.0000000000000002");
  a.F_Do_W.force_N.x = 0.0;
  b.F_Do_W.force_N.x = -0.0;
  EXPECT_EQ(Between(a, b).size(), 1U);
}

TEST(Compare, ListsOfDifferentLengthReportMissingItems) {
  core::LogicStatus a, b;
  a.active_states = {"one", "two"};
  b.active_states = {"one"};
  Leaves left, right;
  Field(left, "status", a);
  Field(right, "status", b);
  const auto differences = Compare(left.all(), right.all(), Tolerance{}, [](const std::string& path) { return path; });
  ASSERT_EQ(differences.size(), 2U);
  EXPECT_EQ(differences[0].path, "status.active_states.size");
  EXPECT_EQ(differences[1].path, "status.active_states[1]");
  EXPECT_EQ(differences[1].expected, "'two'");
  EXPECT_EQ(differences[1].got, "nothing");
}

TEST(Tolerance, HoldsPerFieldAbsoluteAndRelative) {
  core::Reaction a, b;
  a.F_Do_W.force_N = {100.0, 0.0, 0.0};
  b.F_Do_W.force_N = {100.1, 1e-9, 0.0};
  EXPECT_TRUE(Between(a, b, "*force_N* abs=1e-8 rel=0.002  # newtons\n").empty());
  EXPECT_EQ(Between(a, b, "*force_N* abs=1e-8 rel=0.0005\n").size(), 1U);
  EXPECT_EQ(Between(a, b, "# nothing is allowed\n*torque_Nm* abs=1\n").size(), 2U);
  EXPECT_TRUE(Between(a, b, "*force_N.x rel=0.01\n*force_N.y ignore\n").empty());
}

TEST(Tolerance, ANotANumberIsNeverWithin) {
  core::Reaction a, b;
  b.F_Do_W.force_N.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Between(a, b, "* abs=1e9 rel=1e9\n").size(), 1U);
  EXPECT_TRUE(Between(b, b, "").empty());
}

TEST(Tolerance, ALineThatCannotBeReadIsNamed) {
  for (const char* text :
       {"ok ignore\nx abs=\n", "ok ignore\nx abs=-1\n", "ok ignore\nx\n", "ok ignore\nx about=1\n"}) {
    const auto parsed = Tolerance::Parse(text, "t.txt");
    ASSERT_FALSE(parsed) << text;
    EXPECT_NE(parsed.error().detail.find("t.txt:2"), std::string::npos) << parsed.error().detail;
  }
}

}  // namespace
}  // namespace replay
