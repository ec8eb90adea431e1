#include "tools/oos/verb/arguments.hpp"

#include <gtest/gtest.h>

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

TEST(Arguments, TakeOnlyNumbersThatMakeSense) {
  const auto parse = [](const char* word) { return *Arguments::Parse({"--seed", word}, kOptions); };
  for (const char* word : {"nan", "inf", "-inf", "1e999", ""}) EXPECT_FALSE(parse(word).number("--seed")) << word;
  for (const char* word : {"-3", "0", "nan"}) EXPECT_FALSE(parse(word).positive("--seed")) << word;
  EXPECT_EQ(parse("2.5").positive("--seed")->value(), 2.5);
  for (const char* word : {"1.5", "-1", "0", "65", "1e40", "seven", " 3"}) {
    EXPECT_FALSE(parse(word).count("--seed", 1, 64)) << word;
  }
  EXPECT_EQ(parse("64").count("--seed", 1, 64)->value(), 64U);
  EXPECT_FALSE(Arguments::Parse({}, kOptions)->count("--seed", 1, 64)->has_value());
}

}  // namespace
}  // namespace oos
