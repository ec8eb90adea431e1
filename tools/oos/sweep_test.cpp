#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include "scene/load_scenario.hpp"
#include "tools/oos/sweep_plan.hpp"
#include "tools/oos/sweep_results.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

std::filesystem::path Scenario(const std::string& name) {
  return std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name / "scenario.xml";
}

class Sweep : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(out_);
    // The nodes' and this project's programs, not those of somebody's PATH.
    setenv("VR_OOS_BIN_DIR", (std::filesystem::path(VR_OOS_BINARY_DIR) / "bin").c_str(), 1);
  }
  void TearDown() override { unsetenv("VR_OOS_BIN_DIR"); }

  int Run(std::vector<std::string> words) {
    words.insert(words.begin(), {"sweep", Scenario("free_collision").string(), "--out", out_.string()});
    return RunCommandLine(words);
  }
  [[nodiscard]] std::string Read(const std::string& name) const {
    std::ifstream in(out_ / name);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  std::filesystem::path out_ = std::filesystem::path(testing::TempDir()) / ("sweep_" + std::to_string(getpid())) /
                               testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST(SweepPlan, ARangeHasBothEndsAndEqualSteps) {
  const auto axis = ParseAxis("object[block a].mass_kg=1:4:4");
  ASSERT_TRUE(axis.has_value()) << axis.error().detail;
  EXPECT_EQ(axis->element, "object");
  EXPECT_EQ(axis->element_name, "block a");
  EXPECT_EQ(axis->attribute, "mass_kg");
  EXPECT_EQ(axis->values, (std::vector<std::string>{"1", "2", "3", "4"}));
  EXPECT_EQ(ParseAxis("run.method=paper,fast")->values, (std::vector<std::string>{"paper", "fast"}));
}

TEST(SweepPlan, WhatIsNoAxisIsRefusedWithTheForm) {
  for (const char* text : {"", "mass_kg", "=1:2:3", "mass_kg=1:2", "mass_kg=1:2:1", "mass_kg=a:2:3",
                           "object[a.mass=1:2:3", "mass_kg=", "object.=1:2:3"}) {
    const auto axis = ParseAxis(text);
    ASSERT_FALSE(axis.has_value()) << text;
    EXPECT_NE(axis.error().detail.find("NAME=LOW:HIGH:N"), std::string::npos) << text;
  }
}

TEST(SweepPlan, EveryPointOfTheGridIsRunWithEverySeedOnce) {
  const std::vector<SweepRun> runs = PlanRuns({*ParseAxis("a=1:3:3"), *ParseAxis("b=x,y")}, 5);
  ASSERT_EQ(runs.size(), 30u);
  std::set<std::string> different;
  for (const SweepRun& run : runs) {
    different.insert(run.values[0] + " " + run.values[1] + " " + std::to_string(run.seed));
  }
  EXPECT_EQ(different.size(), 30u);
}

TEST_F(Sweep, ACopyNeedsNothingOutsideItsFolderAndHasTheValues) {
  const auto axis = ParseAxis("run.seed=7,8");
  ASSERT_TRUE(WriteScenarioCopy(Scenario("free_collision"), {*axis}, {"8"}, out_ / "copy").has_value());
  const auto scenario = scene::LoadScenario(out_ / "copy" / "scenario.xml");
  ASSERT_TRUE(scenario.has_value());
  EXPECT_EQ(scenario->seed, 8u);
  for (const scene::Object& object : scenario->objects) {
    const std::string mesh = object.visual_mesh.lexically_normal().string();
    EXPECT_EQ(mesh.find((out_ / "copy").string()), 0u) << mesh;
  }
}

TEST_F(Sweep, AnAttributeThatNobodyHasAndAValueThatIsNoneAreRefused) {
  EXPECT_EQ(Run({"--grid", "object.colour_of_the_sky=1:2:2", "--dry-run"}), kBadUsage);
  EXPECT_EQ(Run({"--grid", "nothing_has_this=1:2:2", "--dry-run"}), kBadUsage);
  EXPECT_EQ(Run({"--grid", "run.method=magic", "--dry-run"}), kBadUsage);
  EXPECT_TRUE(std::filesystem::is_empty(out_ / "runs")) << "nothing half-built";
}

// A run that has ended is not repeated; one that has not is; another plan does not go into the same folder.
TEST_F(Sweep, GoesOnWhereItStoppedAndEndsWithATableAndAChart) {
  const std::vector<std::string> words = {"--grid", "run.method=paper,fast", "--seeds", "2", "--jobs", "2"};
  ASSERT_EQ(Run(words), kHolds);
  const std::string table = Read("results.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5) << table;
  EXPECT_NE(Read("results.svg").find("<svg"), std::string::npos);
  const std::string log = Read("jobs.log");
  const auto first_report = std::filesystem::last_write_time(out_ / "runs" / "00001" / "out" / "report.json");

  // As after a kill: one run is not in the log, which has them in the order in which they ended, and left something
  // half done.
  const std::size_t fourth = log.find("\n4\t") + 1;
  ASSERT_NE(fourth, 0u) << log;
  std::ofstream(out_ / "jobs.log") << log.substr(0, fourth) + log.substr(log.find('\n', fourth) + 1);
  std::filesystem::remove(out_ / "runs" / "00004" / "out" / "report.json");
  ASSERT_EQ(Run(words), kHolds);
  EXPECT_EQ(Read("results.csv"), table);
  EXPECT_EQ(std::filesystem::last_write_time(out_ / "runs" / "00001" / "out" / "report.json"), first_report);

  EXPECT_EQ(Run({"--grid", "run.method=paper", "--seeds", "2"}), kBadUsage);
}

}  // namespace
}  // namespace oos
