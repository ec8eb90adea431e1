#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/process/piped_child.hpp"

namespace oos {
namespace {

using testing::HasSubstr;

class NodeCommandLine : public testing::TestWithParam<const char*> {
 protected:
  static process::Answer Run(std::vector<std::string> words) {
    words.insert(words.begin(), std::string(VR_OOS_BINARY_DIR) + "/bin/" + GetParam());
    const auto answer = process::RunHere(words);
    EXPECT_TRUE(answer) << answer.error().detail;
    return answer.value_or(process::Answer{});
  }
};

TEST_P(NodeCommandLine, RefusesAnUnknownOptionAndNamesTheNearest) {
  const process::Answer answer = Run({"--scenrio", "scenario.xml"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("unknown option --scenrio; did you mean --scenario?"));
}

TEST_P(NodeCommandLine, RefusesAValueOutOfRange) {
  const process::Answer answer = Run({"--session", "-1"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("--session needs a whole number, 0 or more, not '-1'"));
}

TEST_P(NodeCommandLine, SaysWhatIsMissing) {
  const process::Answer answer = Run({});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("is missing"));
}

TEST_P(NodeCommandLine, HelpListsTheOptions) {
  const process::Answer answer = Run({"--help"});
  EXPECT_EQ(answer.status, 0);
  for (const char* text : {"usage: ", "--scenario FILE", "--registry ENDPOINT", "--no_encryption"}) {
    EXPECT_THAT(answer.out, HasSubstr(text));
  }
}

INSTANTIATE_TEST_SUITE_P(Nodes, NodeCommandLine,
                         testing::Values("device_bridge", "haptic_node", "physics_node", "haptic_physics_node",
                                         "logic_node", "visual_node"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace oos
