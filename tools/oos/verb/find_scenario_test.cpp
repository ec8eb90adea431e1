#include "tools/oos/verb/find_scenario.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace oos {
namespace {

namespace fs = std::filesystem;

class FindScenarioTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("find_scenario-" + std::to_string(getpid()));
    fs::create_directories(root_ / "prefix/libexec/vr-oos");
    fs::create_directories(root_ / "source/build/demo/bin");
    for (const char* folder : {"prefix/share/vr-oos/scenarios/touch", "source/scenarios/touch"}) {
      fs::create_directories(root_ / folder);
      std::ofstream(root_ / folder / "scenario.xml") << "<scenario/>";
    }
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(FindScenarioTest, ANameIsFoundAmongTheInstalledScenarios) {
  EXPECT_EQ(FindScenario("touch", root_ / "prefix/libexec/vr-oos"), root_ / "prefix/share/vr-oos/scenarios/touch");
}

TEST_F(FindScenarioTest, ANameIsFoundInTheSourceTreeOfABuild) {
  EXPECT_EQ(FindScenario("touch", root_ / "source/build/demo/bin"), root_ / "source/scenarios/touch");
}

TEST_F(FindScenarioTest, APathIsTakenAsItIs) {
  const std::string path = (root_ / "source/scenarios/touch").string();
  EXPECT_EQ(FindScenario(path, root_ / "prefix/libexec/vr-oos"), path);
}

TEST_F(FindScenarioTest, WhatIsFoundNowhereIsReturnedAsGiven) {
  EXPECT_EQ(FindScenario("no_such", root_ / "prefix/libexec/vr-oos"), "no_such");
  EXPECT_EQ(FindScenario("some/touch", root_ / "prefix/libexec/vr-oos"), "some/touch");
}

TEST_F(FindScenarioTest, KnowsTheNamesOfFoldersWithAScenario) {
  fs::create_directories(root_ / "source/scenarios/parts");
  EXPECT_EQ(KnownScenarios(root_ / "source/build/demo/bin"), std::vector<std::string>{"touch"});
  EXPECT_TRUE(KnownScenarios(root_).empty());
}

}  // namespace
}  // namespace oos
