#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/failures/bench.hpp"
#include "tools/failures/studies/studies.hpp"

namespace failures {
namespace {

// What the default method missed, by the study's own bounds.
std::vector<std::string> MissedBy(void (*study)(Report*)) {
  Report report;
  testing::internal::CaptureStdout();
  study(&report);
  testing::internal::GetCapturedStdout();
  EXPECT_FALSE(report.goals.empty());
  std::vector<std::string> missed;
  for (const bench::Goal& goal : report.goals) {
    if (goal.verdict != bench::Verdict::kMet) missed.push_back(goal.what + ": " + goal.measured);
  }
  return missed;
}

TEST(FailureTests, RefuseAnUnknownStudyAndNameTheKnownOnes) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(BenchMain({{}, {}, "rest,colour"}, {}), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("no 'colour' to measure; known: thin"));
}

TEST(FailureTests, TheHandFeelsTheFrictionOfTheCone) {
  EXPECT_THAT(MissedBy([](Report* report) { StudyFriction({}, report); }), testing::IsEmpty());
}

TEST(FailureTests, TheForceTurnsSmoothlyOverAnEdge) {
  EXPECT_THAT(MissedBy(StudyEdges), testing::IsEmpty());
}

// Where two faces of the hole meet, each is felt in every cycle, and where friction holds the peg it rests: without the
// one and the other it trembles by 30 um.
TEST(FailureTests, APegThatIsStuckInItsHoleLiesStill) {
  EXPECT_LT(PegJitter_m(2e-4, 0.3, 8), 2e-6);
}

TEST(FailureTests, NoContactIsLate) {
  EXPECT_THAT(MissedBy(StudyLateness), testing::IsEmpty());
}

}  // namespace
}  // namespace failures
