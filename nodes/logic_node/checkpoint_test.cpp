#include "nodes/logic_node/checkpoint.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace logic_node {
namespace {

const std::filesystem::path kFile = std::filesystem::path(testing::TempDir()) / "logic_node.checkpoint";

TEST(LogicCheckpoint, ReadsBackWhatWasWritten) {
  const Checkpoint written = {{1, 2, 0, 255, '\n'}, {{"haptic_node", "force_cap_N", 0.1}, {"*", "a.b", -1e300}}};
  ASSERT_TRUE(WriteCheckpoint(written, kFile));
  const auto read = ReadCheckpoint(kFile);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->state, written.state);
  ASSERT_EQ(read->applied.size(), 2U);
  EXPECT_EQ(read->applied[0].owner, "haptic_node");
  EXPECT_EQ(read->applied[0].value, 0.1);
  EXPECT_EQ(read->applied[1].value, -1e300);
}

TEST(LogicCheckpoint, RefusesATruncatedOrModifiedFile) {
  ASSERT_TRUE(WriteCheckpoint({{1, 2, 3}, {{"o", "p", 1.0}}}, kFile));
  std::string good;
  {
    std::ifstream in(kFile, std::ios::binary);
    good.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::ofstream(kFile, std::ios::binary) << good.substr(0, at);
    EXPECT_FALSE(ReadCheckpoint(kFile)) << "cut at " << at;
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    std::ofstream(kFile, std::ios::binary) << bad;
    EXPECT_FALSE(ReadCheckpoint(kFile)) << "changed at " << at;
  }
}

TEST(LogicCheckpoint, ReportsAFileThatCannotBeWritten) {
  EXPECT_FALSE(WriteCheckpoint({}, "/no_such_folder/logic_node.checkpoint"));
}

}  // namespace
}  // namespace logic_node
