#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "tools/failures/bench.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/testing/documented_rows.hpp"

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

// F15 and F21 are bounds of processor time, which the machine and what else it does move across: both are measured and
// written, and whoever brings the page up to date judges them.
Verdicts WithoutProcessorTime(Verdicts verdicts) {
  std::erase_if(verdicts,
                [](const auto& row) { return row.first.starts_with("F15,") || row.first.starts_with("F21,"); });
  return verdicts;
}

// A failure that is new and one that is mended both ask for the page: docs/performance/stability.md says how.
TEST(FailureTests, ExactlyTheDocumentedRowsAreMissed) {
  std::filesystem::current_path(VR_OOS_SOURCE_DIR);  // the studies read shipped scenes from there
  const auto folder = std::filesystem::temp_directory_path() / ("vr_oos_rows_" + std::to_string(::getpid()));
  ASSERT_EQ(BenchMain({folder / "all.json", folder, ""}, {}), 0);
  const Verdicts measured = ReadVerdicts(folder / "rows.csv"), documented = DocumentedVerdicts(VR_OOS_SOURCE_DIR);
  EXPECT_EQ(measured.size(), documented.size());
  EXPECT_THAT(Contradictions(WithoutProcessorTime(measured), WithoutProcessorTime(documented)), testing::IsEmpty());
  EXPECT_TRUE(std::filesystem::exists(folder / "boundary.svg"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace failures
