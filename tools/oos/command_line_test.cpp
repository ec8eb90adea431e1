#include "tools/oos/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace oos {
namespace {

TEST(CommandLine, BadUsageIsStatusTwo) {
  EXPECT_EQ(RunCommandLine({}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"fly"}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"run"}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"run", "/nonexistent/scenario.xml"}), kBadUsage);
}

TEST(CommandLine, EveryVerbRefusesAnUnknownOption) {
  for (const Verb& verb : AllVerbs()) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunCommandLine({std::string(verb.name), "--no_such_option_anywhere"}), kBadUsage) << verb.name;
    const std::string complaint = testing::internal::GetCapturedStderr();
    EXPECT_NE(complaint.find("unknown option --no_such_option_anywhere"), std::string::npos) << complaint;
  }
}

TEST(CommandLine, SuggestsTheNearestVerbOrOptionForAMisspelledOne) {
  const auto complaint = [](const std::vector<std::string>& words) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunCommandLine(words), kBadUsage);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(complaint({"rnu"}).find("did you mean 'run'?"), std::string::npos);
  EXPECT_NE(complaint({"run", "touch", "--wrokers", "2"}).find("unknown option --wrokers; did you mean --workers?"),
            std::string::npos);
}

TEST(CommandLine, EveryVerbHasHelp) {
  for (const Verb& verb : AllVerbs()) {
    EXPECT_EQ(RunCommandLine({std::string(verb.name), "--help"}), kHolds) << verb.name;
    EXPECT_FALSE(verb.summary.empty());
  }
}

TEST(CommandLine, TellsItsVersion) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunCommandLine({"--version"}), kHolds);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::MatchesRegex("oos [0-9]+.[0-9]+.[0-9]+ \\(.+\\)\n"));
}

}  // namespace
}  // namespace oos
