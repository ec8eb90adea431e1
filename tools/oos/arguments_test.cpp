#include "tools/oos/arguments.hpp"

#include <gtest/gtest.h>

#include "tools/oos/verb.hpp"

namespace oos {
namespace {

const std::vector<Option> kOptions = {{"--seed", "N", ""}, {"--lockstep", "", ""}, {"--set", "P=V", ""}};

TEST(Arguments, SeparateOptionsFromPositionalWords) {
  const auto arguments =
      Arguments::Parse({"scenarios/touch", "--seed", "7", "--lockstep", "--set", "a=1", "--set=b=2"}, kOptions);
  ASSERT_TRUE(arguments) << arguments.error().detail;
  EXPECT_EQ(arguments->positional(), std::vector<std::string>{"scenarios/touch"});
  EXPECT_EQ(arguments->number("--seed")->value(), 7.0);
  EXPECT_TRUE(arguments->has("--lockstep"));
  EXPECT_EQ(arguments->texts("--set"), (std::vector<std::string>{"a=1", "b=2"}));
}

TEST(Arguments, NameTheUnknownOptionAndTheKnownOnes) {
  const auto arguments = Arguments::Parse({"--sead", "7"}, kOptions);
  ASSERT_FALSE(arguments);
  EXPECT_NE(arguments.error().detail.find("--sead"), std::string::npos);
  EXPECT_NE(arguments.error().detail.find("--seed"), std::string::npos);
}

TEST(Arguments, RefuseANumberThatIsNone) {
  const auto arguments = Arguments::Parse({"--seed", "seven"}, kOptions);
  ASSERT_TRUE(arguments);
  EXPECT_FALSE(arguments->number("--seed"));
}

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
