#include "tools/dynamics/bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace dynamics {
namespace {

std::string Read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(DynamicsBench, RefusesAnUnknownStudyAndNamesTheKnownOnes) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(BenchMain({{}, {}, "rotation,colour"}, {}), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("no 'colour' to measure; known: rotation"));
}

TEST(DynamicsBench, WritesChartTableAndGoalsOfTheChosenStudies) {
  const auto folder = std::filesystem::temp_directory_path() / ("vr_oos_dynamics_" + std::to_string(::getpid()));
  testing::internal::CaptureStdout();
  EXPECT_EQ(BenchMain({folder / "all.json", folder, "rebound"}, {}), 0);
  testing::internal::GetCapturedStdout();
  EXPECT_THAT(Read(folder / "rebound.svg"), testing::HasSubstr("exp(pi w t / 2)"));
  EXPECT_THAT(Read(folder / "rebound.csv"), testing::HasSubstr("\nwrench,flat,0.2,10000,0,1,"));
  EXPECT_THAT(Read(folder / "goals.md"), testing::HasSubstr("| 0.98 to 1.02 |"));
  EXPECT_THAT(Read(folder / "all.json"), testing::HasSubstr("\"bench\": \"physics\""));
  EXPECT_FALSE(std::filesystem::exists(folder / "rotation.svg"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace dynamics
