#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tools/oos/replay/verbs.hpp"

namespace oos {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSource = VR_OOS_SOURCE_DIR;
const std::string kGolden = (kSource / "tests/golden/module_replacement.mcap").string();
const std::string kScenario = (kSource / "scenarios/module_replacement/paper.xml").string();

// Exit status; what was printed is in `out`, complaints too.
int Replay(std::vector<std::string> words, std::string* out) {
  words.insert(words.begin(), "replay");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int status = RunVerbs({ReplayVerb()}, words);
  std::fflush(stdout);
  *out = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
  return status;
}

TEST(ReplayVerb, EqualIsStatusZeroAndPrintsTheSpeed) {
  std::string out;
  EXPECT_EQ(Replay({kGolden, "--node", "logic_node", "--scenario", kScenario}, &out), kHolds) << out;
  EXPECT_THAT(out, HasSubstr("logic_node: 100 steps"));
  EXPECT_THAT(out, HasSubstr("times real time"));
  EXPECT_THAT(out, HasSubstr("equal"));
}

TEST(ReplayVerb, DifferentIsStatusOneAndNamesTickTopicAndField) {
  std::string out;
  EXPECT_EQ(
      Replay({kGolden, "--node", "physics_node", "--scenario", kScenario, "--set", "hook_old.stiffness_N_per_m=19000"},
             &out),
      kDoesNotHold)
      << out;
  EXPECT_THAT(out, HasSubstr("first: tick 36"));
  EXPECT_THAT(out, HasSubstr("topic physics/state, field bodies["));
  EXPECT_THAT(out, HasSubstr("of handle: expected"));
  EXPECT_THAT(out, HasSubstr("how it grows"));
}

TEST(ReplayVerb, AWideToleranceMakesThemEqualAndIsReported) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("tolerance" + std::to_string(::getpid()) + ".txt");
  std::ofstream(file) << "physics/* abs=1e6  # anything\nevent:* ignore\n";
  std::string out;
  EXPECT_EQ(Replay({kGolden, "--node", "physics_node", "--scenario", kScenario, "--set",
                    "hook_old.stiffness_N_per_m=19999", "--tolerance", file.string()},
                   &out),
            kDoesNotHold)
      << "a hash is not near another one: " << out;
  std::ofstream(file) << "physics/state:state_hash ignore\nphysics/* abs=1e6\nevent:* ignore\n";
  EXPECT_EQ(Replay({kGolden, "--node", "physics_node", "--scenario", kScenario, "--set",
                    "hook_old.stiffness_N_per_m=19999", "--tolerance", file.string()},
                   &out),
            kHolds)
      << out;
  EXPECT_THAT(out, HasSubstr("equal within the tolerance"));
  std::filesystem::remove(file);
}

TEST(ReplayVerb, BadInputIsStatusTwoAndNamesTheError) {
  std::string out;
  EXPECT_EQ(Replay({kGolden + ".gone", "--check"}, &out), kBadUsage);
  EXPECT_EQ(Replay({kGolden, "--node", "visual_node"}, &out), kBadUsage);
  EXPECT_THAT(out, HasSubstr("no steps of visual_node"));
  EXPECT_EQ(Replay({kGolden, "--check", "--speed", "0"}, &out), kBadUsage);
  EXPECT_THAT(out, HasSubstr("--speed"));
  EXPECT_EQ(Replay({kGolden, "--check", "--set", "x"}, &out), kBadUsage);
  EXPECT_EQ(Replay({kGolden, "--check", "--scenario", kScenario, "--set", "hook_old.engage_force=1"}, &out), kBadUsage);
  EXPECT_THAT(out, HasSubstr("did you mean 'hook_old.engage_force_N'"));
  EXPECT_EQ(Replay({kGolden, "--check", "--tolerance", kGolden + ".gone"}, &out), kBadUsage);
  EXPECT_EQ(Replay({kGolden, "--node", "logic_node", "--scenario", kGolden}, &out), kBadUsage);
  EXPECT_THAT(out, HasSubstr("--scenario"));
}

}  // namespace
}  // namespace oos
