#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "bus/codec.hpp"
#include "bus/log/recorder.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

class RecordingVerbTest : public ::testing::Test {
 protected:
  RecordingVerbTest() {
    std::filesystem::remove(file_);
    auto recorder = std::move(*bus::log::Recorder::Create(file_, {{"session", "7"}}));
    for (std::uint64_t i : {1, 2, 5}) {  // 3 and 4 were lost on the way
      bus::Observation o;
      o.topic = "logic/status";
      o.topic_class = bus::TopicClass::kState;
      o.type = bus::MessageType::kLogicStatus;
      o.writer = "logic_node";
      o.sequence = i;
      o.received_ns = static_cast<std::int64_t>(1'000'000 * i);
      core::LogicStatus status;
      status.step = "step_" + std::to_string(i);
      bus::EncodeState(status, &o.payload);
      EXPECT_TRUE(recorder->Add(o));
    }
    EXPECT_TRUE(recorder->Close(0, 0));
  }
  ~RecordingVerbTest() override {
    std::filesystem::remove(file_);
    std::filesystem::remove(mended_);
  }
  static std::string OutputOf(const std::vector<std::string>& words, int expected_status) {
    ::testing::internal::CaptureStdout();
    const int status = RunCommandLine(words);
    std::fflush(stdout);
    const std::string output = ::testing::internal::GetCapturedStdout();
    EXPECT_EQ(status, expected_status) << output;
    return output;
  }

  std::filesystem::path file_ =
      std::filesystem::path(::testing::TempDir()) / ("recording" + std::to_string(::getpid()) + ".mcap");
  std::filesystem::path mended_ = file_.string() + ".mended";
};

TEST_F(RecordingVerbTest, InfoTellsTopicsRatesAndLosses) {
  const std::string output = OutputOf({"info", file_.string()}, kHolds);
  EXPECT_NE(output.find("3 messages in 0.004 s, 1 chunks, complete"), std::string::npos) << output;
  EXPECT_NE(output.find("session=7"), std::string::npos) << output;
  // messages, Hz, kB, lost
  EXPECT_NE(output.find("3     500.0"), std::string::npos) << output;
  EXPECT_NE(output.find("2  oos.LogicStatus"), std::string::npos) << output;
}

TEST_F(RecordingVerbTest, CatPrintsAMessagePerLineByTheEmbeddedDescriptors) {
  const std::string output = OutputOf({"cat", file_.string(), "logic/*"}, kHolds);
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 3);
  EXPECT_NE(output.find("\"step\":\"step_5\""), std::string::npos) << output;
  EXPECT_EQ(OutputOf({"cat", file_.string(), "physics/*"}, kHolds), "");
}

TEST_F(RecordingVerbTest, RecoverMendsACutFileAndInfoSaysThatItWasCut) {
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 20);
  EXPECT_NE(OutputOf({"info", file_.string()}, kHolds).find("NOT closed"), std::string::npos);
  EXPECT_NE(OutputOf({"recover", file_.string(), mended_.string()}, kHolds).find("3 messages"), std::string::npos);
  EXPECT_NE(OutputOf({"info", mended_.string()}, kHolds).find("complete"), std::string::npos);
}

TEST_F(RecordingVerbTest, AMissingFileIsBadUsage) {
  OutputOf({"info", file_.string() + ".gone"}, kBadUsage);
  OutputOf({"cat", file_.string() + ".gone"}, kBadUsage);
  OutputOf({"recover", file_.string() + ".gone", mended_.string()}, kBadUsage);
  EXPECT_FALSE(std::filesystem::exists(mended_));
}

}  // namespace
}  // namespace oos
