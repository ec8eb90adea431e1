// Walls of a room on three machines, beside a viewer of another view: launched, in step, collected.

#include <gmock/gmock.h>

#include "tests/lab/lab_support.hpp"
#include "tests/wall_frames.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

constexpr const char* kPictures = R"(  <view name="teacher" host="alpha" layout="overview | *" size="160x90"/>
  <room name="cave" user="operator">
    <screen name="front" host="beta" lower_left="-1 1 -1" lower_right="1 1 -1" upper_left="-1 1 1" size="96x96"/>
    <screen name="left" host="gamma" lower_left="-1 -1 -1" lower_right="-1 1 -1" upper_left="-1 -1 1" size="96x96"/>
    <screen name="right" host="alpha" lower_left="1 1 -1" lower_right="1 -1 -1" upper_left="1 1 1" size="96x96"/>
  </room>
</lab>
)";

class WallsInALab : public LabTest {};

// Each machine has a clock of its own; the test knows exactly how far they are apart.
TEST_F(WallsInALab, ShowTheSameStateInStepOnThreeMachines) {
  std::map<std::string, std::string> hosts = OnThree();
  hosts.erase("visual_node");
  const std::string lab = WriteLab("walls", hosts);
  std::string text;
  {
    std::ifstream in(lab);
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  std::ofstream(lab) << text.replace(text.find("</lab>\n"), 7, kPictures);
  const std::filesystem::path out = Folder("walls_out");
  const process::Answer answer = Run(Launch(lab, {"--out", out.string()}), 300.0);
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  ExpectNothingIsLeft();
  const auto frames_of = [&](const char* wall, const char* machine) {
    WallFrames frames = ReadWallFrames(out / (std::string("visual_node-") + wall) / "walls.csv");
    for (auto& [number, frame] : frames) frame.shown_ns -= ClockOf(machine);
    return frames;
  };
  const WallComparison walls({frames_of("front", "beta"), frames_of("left", "gamma"), frames_of("right", "alpha")});
  ASSERT_GT(walls.num_common, 50u);
  RecordProperty("common_frames", std::to_string(walls.num_common));
  RecordProperty("frames_of_different_states", std::to_string(walls.num_other_states));
  RecordProperty("median_apart_ms", std::to_string(walls.apart_ms_at(0.5)));
  RecordProperty("p90_apart_ms", std::to_string(walls.apart_ms_at(0.9)));
  EXPECT_EQ(walls.num_overtaken, 0u);
  EXPECT_LE(walls.num_other_states, walls.num_common / 50);
  EXPECT_LE(walls.apart_ms_at(0.9), 1e3 / 30.0);
  EXPECT_TRUE(std::filesystem::exists(out / "visual_node-teacher" / "contact_sheet.png"));
}

}  // namespace
}  // namespace system_tests
