#include "cli/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cli {
namespace {

using testing::HasSubstr;

Syntax RunSyntax() {
  Syntax syntax;
  syntax.program = "oos run";
  syntax.summary = "starts all nodes";
  syntax.positional = "SCENARIO";
  syntax.max_positional = 2;
  syntax.options = {{"--seed", "N", "of the operator"},
                    {"--lockstep", "", "in one process"},
                    {"--set", "P=V", "a parameter"},
                    {"--workers", "N", "threads", "1", Count(1, 64)},
                    {"--rt", "off|try", "priority", "try", OneOf("off|try")},
                    {"--patience_s", "S", "how long", "3", Number(0.0, 3600.0)}};
  return syntax;
}

core::Result<Arguments> Parse(const std::vector<std::string>& words) {
  return Arguments::Parse(words, RunSyntax());
}

std::string Refusal(const std::vector<std::string>& words) {
  const auto arguments = Parse(words);
  return arguments ? "" : arguments.error().detail;
}

TEST(Arguments, SeparateOptionsFromPositionalWords) {
  const auto arguments = Parse({"scenarios/touch", "--seed", "7", "--lockstep", "--set", "a=1", "--set=b=2"});
  ASSERT_TRUE(arguments) << arguments.error().detail;
  EXPECT_EQ(arguments->positional(), std::vector<std::string>{"scenarios/touch"});
  EXPECT_EQ(arguments->number("--seed")->value(), 7.0);
  EXPECT_TRUE(arguments->has("--lockstep"));
  EXPECT_EQ(arguments->texts("--set"), (std::vector<std::string>{"a=1", "b=2"}));
}

TEST(Arguments, NameTheUnknownOptionAndTheKnownOnes) {
  const auto arguments = Parse({"--sead", "7"});
  ASSERT_FALSE(arguments);
  EXPECT_NE(arguments.error().detail.find("--sead"), std::string::npos);
  EXPECT_NE(arguments.error().detail.find("--seed"), std::string::npos);
}

TEST(Arguments, RefuseANumberThatIsNone) {
  const auto arguments = Parse({"--seed", "seven"});
  ASSERT_TRUE(arguments);
  EXPECT_FALSE(arguments->number("--seed"));
}

TEST(Arguments, TakeOnlyNumbersThatMakeSense) {
  const auto parse = [](const char* word) { return *Parse({"--seed", word}); };
  for (const char* word : {"nan", "inf", "-inf", "1e999", ""}) EXPECT_FALSE(parse(word).number("--seed")) << word;
  for (const char* word : {"-3", "0", "nan"}) EXPECT_FALSE(parse(word).positive("--seed")) << word;
  EXPECT_EQ(parse("2.5").positive("--seed")->value(), 2.5);
  for (const char* word : {"1.5", "-1", "0", "65", "1e40", "seven", " 3"}) {
    EXPECT_FALSE(parse(word).count("--seed", 1, 64)) << word;
  }
  EXPECT_EQ(parse("64").count("--seed", 1, 64)->value(), 64U);
  EXPECT_FALSE(Parse({})->count("--seed", 1, 64)->has_value());
}

TEST(Arguments, NameTheNearestOptionToAnUnknownOne) {
  EXPECT_EQ(Refusal({"--wrokers", "4"}), "unknown option --wrokers; did you mean --workers?");
  EXPECT_EQ(Refusal({"--lokcstep"}), "unknown option --lokcstep; did you mean --lockstep?");
  EXPECT_EQ(Refusal({"--workres=4"}), "unknown option --workres; did you mean --workers?");
  EXPECT_THAT(Refusal({"--quantum"}), HasSubstr("unknown option --quantum; known: --seed --lockstep --set"));
  EXPECT_THAT(Refusal({"-w"}), HasSubstr("unknown option -w"));
}

TEST(Arguments, RefuseAMissingValueAndOneTooMany) {
  EXPECT_EQ(Refusal({"--set"}), "--set needs a value: P=V");
  EXPECT_EQ(Refusal({"--lockstep=yes"}), "--lockstep takes no value");
  EXPECT_EQ(Refusal({"a", "b", "c"}), "no place for 'c'; usage: oos run SCENARIO");
}

TEST(Arguments, TakeNegativeNumbersAndWordsBehindTwoDashesAsWords) {
  EXPECT_EQ(Parse({"a", "-5"})->positional(), (std::vector<std::string>{"a", "-5"}));
  EXPECT_EQ(Parse({"a", "-.5"})->positional(), (std::vector<std::string>{"a", "-.5"}));
  EXPECT_EQ(Parse({"--", "--lockstep", "-x"})->positional(), (std::vector<std::string>{"--lockstep", "-x"}));
  EXPECT_EQ(Parse({"--seed", "-5"})->text("--seed"), "-5");
  EXPECT_EQ(Parse({"--set", "[a,b]", "c"})->texts("--set"), std::vector<std::string>{"[a,b]"});
  EXPECT_EQ(Parse({"--set", ""})->texts("--set"), std::vector<std::string>{""});
}

TEST(Arguments, CheckDeclaredRangesAndGiveDeclaredFallbacks) {
  const auto none = Parse({});
  ASSERT_TRUE(none) << none.error().detail;
  EXPECT_FALSE(none->has("--workers"));
  EXPECT_EQ(none->checked_count("--workers"), 1U);
  EXPECT_EQ(none->checked_number("--patience_s"), 3.0);
  EXPECT_EQ(none->text("--rt"), "try");
  EXPECT_EQ(Parse({"--workers", "64"})->checked_count("--workers"), 64U);
  EXPECT_EQ(Refusal({"--workers", "65"}), "--workers needs a whole number from 1 to 64, not '65'");
  EXPECT_EQ(Refusal({"--patience_s", "nan"}), "--patience_s needs a number from 0 to 3600, not 'nan'");
  EXPECT_EQ(Refusal({"--rt", "hard"}), "--rt needs off or try, not 'hard'");
}

TEST(Arguments, OfAnOptionGivenTwiceTheLastValueCounts) {
  EXPECT_EQ(Parse({"--workers", "2", "--workers", "3"})->checked_count("--workers"), 3U);
}

TEST(Help, NamesEveryOptionWithItsValueRangeAndDefault) {
  ASSERT_TRUE(Parse({"--help"})->wants_help());
  ASSERT_TRUE(Parse({"-h"})->wants_help());
  const std::string help = Help(RunSyntax());
  EXPECT_THAT(help, HasSubstr("usage: oos run SCENARIO [options]"));
  EXPECT_THAT(help, HasSubstr("starts all nodes"));
  EXPECT_THAT(help, HasSubstr("--workers N"));
  EXPECT_THAT(help, HasSubstr("threads; a whole number from 1 to 64; default: 1"));
  EXPECT_THAT(help, HasSubstr("--help"));
}

}  // namespace
}  // namespace cli
