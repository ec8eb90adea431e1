#include "tools/oos/command_line.hpp"

#include <gtest/gtest.h>

namespace oos {
namespace {

TEST(CommandLine, BadUsageIsStatusTwo) {
  EXPECT_EQ(RunCommandLine({}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"fly"}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"run"}), kBadUsage);
  EXPECT_EQ(RunCommandLine({"run", "/nonexistent/scenario.xml"}), kBadUsage);
}

TEST(CommandLine, EveryVerbExplainsItself) {
  for (const Verb& verb : AllVerbs()) {
    EXPECT_EQ(RunCommandLine({std::string(verb.name), "--help"}), kHolds) << verb.name;
    EXPECT_FALSE(verb.summary.empty());
  }
}

}  // namespace
}  // namespace oos
