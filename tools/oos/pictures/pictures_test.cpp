#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "bus/log/recorder.hpp"
#include "bus/wire/codec.hpp"
#include "tools/oos/pictures/video.hpp"
#include "tools/process/piped_child.hpp"

namespace oos {
namespace {

using testing::HasSubstr;

const std::string kScenario = VR_OOS_SOURCE_DIR "/scenarios/touch/scenario.xml";

class PicturesTest : public testing::Test {
 protected:
  PicturesTest() {
    std::filesystem::create_directories(folder_);
    auto recorder = std::move(*bus::log::Recorder::Create(recording_, {}, {{"scenario", {{"file", kScenario}}}}));
    for (const int tenths : {0, 10}) {
      core::PhysicsState state;
      state.bodies.resize(1);
      std::vector<std::uint8_t> bytes(2000);
      bytes.resize(bus::LatestCodec<core::PhysicsState>().Encode(state, 0, 1000, bytes.data(), bytes.size()));
      bus::Observation seen;
      seen.topic = bus::kPhysicsStateTopic;
      seen.type = bus::MessageType::kPhysicsState;
      seen.sequence = static_cast<std::uint64_t>(tenths + 1);
      seen.received_ns = 1'000'000'000 + tenths * 100'000'000LL;
      seen.payload.assign(bytes.begin(), bytes.end());
      EXPECT_TRUE(recorder->Add(seen));
    }
    EXPECT_TRUE(recorder->Close(0, 0));
  }
  ~PicturesTest() override { std::filesystem::remove_all(folder_); }

  // `variables`: NAME=VALUE, or -u and a NAME.
  static process::Answer Oos(std::vector<std::string> words, std::vector<std::string> variables = {}) {
    words.insert(words.begin(), std::string(VR_OOS_BINARY_DIR) + "/bin/oos");
    words.insert(words.begin(), variables.begin(), variables.end());
    words.insert(words.begin(), "/usr/bin/env");
    return process::RunHere(words).value_or(process::Answer{});
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("pictures_" + std::to_string(getpid()));
  const std::string recording_ = folder_ / "run.mcap";
  const std::string shot_ = folder_ / "shot.png";
};

TEST_F(PicturesTest, WithoutADisplayTheErrorNamesXvfbRun) {
  const process::Answer answer = Oos({"view", kScenario, "--shot", shot_}, {"-u", "DISPLAY"});
  EXPECT_EQ(answer.status, 1);
  EXPECT_THAT(answer.err, HasSubstr("xvfb-run"));
}

TEST_F(PicturesTest, AMissingFileIsNamed) {
  const process::Answer answer = Oos({"view", folder_ / "nothing.mcap", "--shot", shot_});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("nothing.mcap"));
}

TEST_F(PicturesTest, AnUnknownCameraListsTheCameras) {
  const process::Answer answer = Oos({"view", kScenario, "--shot", shot_, "--camera", "moon"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("the scenario has no camera 'moon'; it has "));
}

TEST_F(PicturesTest, ATimeBeyondTheRecordingIsRefused) {
  const process::Answer answer = Oos({"view", recording_, "--shot", shot_, "--at", "1.5"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("1.500 s is beyond the end of the recording, which is 1.000 s long"));
}

TEST_F(PicturesTest, AScenarioHasNoOtherTimeThanItsBeginning) {
  const process::Answer answer = Oos({"view", kScenario, "--shot", shot_, "--at", "1"});
  EXPECT_EQ(answer.status, 2);
  EXPECT_THAT(answer.err, HasSubstr("--at needs a recording"));
}

TEST_F(PicturesTest, WithoutFfmpegTheErrorNamesThePackage) {
  const process::Answer answer = Oos({"replay", recording_, "--video", folder_ / "film.mp4"}, {"PATH=/nonexistent"});
  EXPECT_EQ(answer.status, 1);
  EXPECT_THAT(answer.err, HasSubstr("apt-get install ffmpeg"));
}

TEST_F(PicturesTest, AVideoHasOneFrameForEachMomentOfTheRecording) {
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') GTEST_SKIP() << "drawing needs a display";
  if (!HasFfmpeg()) GTEST_SKIP() << "encoding needs ffmpeg";
  const std::string film = folder_ / "film.mp4", raw = folder_ / "film.yuv";
  const process::Answer answer =
      Oos({"replay", recording_, "--video", film, "--size", "97x65", "--fps", "5"});  // an odd size, too
  ASSERT_EQ(answer.status, 0) << answer.err;
  const auto decoded =
      process::RunHere({"ffmpeg", "-loglevel", "error", "-i", film, "-f", "rawvideo", "-pix_fmt", "gray", raw});
  ASSERT_TRUE(decoded && decoded->is_good()) << decoded->err;
  EXPECT_EQ(std::filesystem::file_size(raw), 6U * 98U * 66U);
}

}  // namespace
}  // namespace oos
