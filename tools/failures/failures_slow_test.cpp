#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "tools/failures/bench.hpp"
#include "tools/failures/studies/studies.hpp"

namespace failures {
namespace {

TEST(FailureTests, ABudgetOfPointsKeepsTheDeepestAndIsReported) {
  Report report;
  StudyOverload(&report);
  ASSERT_EQ(report.goals.size(), 1U);
  EXPECT_EQ(report.goals[0].verdict, bench::Verdict::kMet) << report.goals[0].measured;
}

TEST(FailureTests, ALightPartUnderAPressingHandLiesStill) {
  Report report;
  StudyLightBodies(&report);
  ASSERT_EQ(report.goals.size(), 1U);
  EXPECT_EQ(report.goals[0].verdict, bench::Verdict::kMet) << report.goals[0].measured;
}

TEST(FailureTests, AreWrittenWithTheirBoundsAndReasons) {
  const auto folder = std::filesystem::temp_directory_path() / ("vr_oos_rows_" + std::to_string(::getpid()));
  ASSERT_EQ(BenchMain({folder / "all.json", folder, ""}, {}), 0);
  std::ostringstream rows;
  rows << std::ifstream(folder / "rows.csv").rdbuf();
  EXPECT_THAT(rows.str(), testing::HasSubstr("\nF1,"));
  EXPECT_THAT(rows.str(), testing::HasSubstr("\nF7,"));
  EXPECT_THAT(rows.str(), testing::HasSubstr("\nF22,"));
  EXPECT_TRUE(std::filesystem::exists(folder / "boundary.svg"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace failures
