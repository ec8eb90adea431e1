#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "bus/log/mcap_writer.hpp"
#include "bus/log/recorder.hpp"
#include "bus/wire/codec.hpp"
#include "tools/oos/record/verbs.hpp"

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
    const int status =
        RunVerbs({RecordVerb(), InfoVerb(), CatVerb(), RecoverVerb(), MergeVerb(), DiffVerb(), ExportVerb()}, words);
    std::fflush(stdout);
    const std::string output = ::testing::internal::GetCapturedStdout();
    EXPECT_EQ(status, expected_status) << output;
    return output;
  }

  std::filesystem::path file_ =
      std::filesystem::path(::testing::TempDir()) / ("recording" + std::to_string(::getpid()) + ".mcap");
  std::filesystem::path mended_ = file_.string() + ".mended";
};

TEST_F(RecordingVerbTest, InfoShowsTopicsRatesAndLosses) {
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

TEST_F(RecordingVerbTest, RecoverRepairsACutFileAndInfoReportsTheCut) {
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 20);
  EXPECT_NE(OutputOf({"info", file_.string()}, kHolds).find("NOT closed"), std::string::npos);
  EXPECT_NE(OutputOf({"recover", file_.string(), mended_.string()}, kHolds).find("3 messages"), std::string::npos);
  EXPECT_NE(OutputOf({"info", mended_.string()}, kHolds).find("complete"), std::string::npos);
}

// Runs in a child process that may allocate only 8 MB more.
TEST_F(RecordingVerbTest, ARecordingTooLargeForMemoryIsRefusedWithItsSizeAndARemedy) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer needs more memory than the limit of this test";
#endif
  constexpr std::size_t kLarge = 128 << 20;  // more than what earlier tests can have left in the allocator
  std::filesystem::remove(file_);
  auto writer = std::move(*bus::log::McapWriter::Create(file_, {"", "test"}));
  ASSERT_TRUE(writer->Write(bus::log::Attachment{0, 0, "large", "text/plain", bus::log::Bytes(kLarge, 7)}));
  ASSERT_TRUE(writer->Close(bus::log::McapWriter::ToDisk::kLater));
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    dup2(pipe_ends[1], STDERR_FILENO);
    std::ifstream statm("/proc/self/statm");
    rlim_t pages = 0;
    for (int field = 0; field < 6; ++field) statm >> pages;  // the sixth: data
    const rlim_t most = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (8 << 20);
    const rlimit limit{most, most};
    if (setrlimit(RLIMIT_DATA, &limit) != 0) _exit(100);
    _exit(RunVerbs({RecordVerb(), InfoVerb(), CatVerb(), RecoverVerb(), MergeVerb(), DiffVerb(), ExportVerb()},
                   {"info", file_.string()}));
  }
  close(pipe_ends[1]);
  std::string said;
  char bytes[256];
  for (ssize_t got = 0; (got = read(pipe_ends[0], bytes, sizeof bytes)) > 0;) said.append(bytes, std::size_t(got));
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), kBadUsage);
  EXPECT_NE(said.find(file_.string() + ": there is not enough memory for it (134 MB)"), std::string::npos) << said;
  EXPECT_NE(said.find("--split_MB"), std::string::npos) << said;
}

TEST_F(RecordingVerbTest, AMissingFileIsBadUsage) {
  OutputOf({"info", file_.string() + ".gone"}, kBadUsage);
  OutputOf({"cat", file_.string() + ".gone"}, kBadUsage);
  OutputOf({"recover", file_.string() + ".gone", mended_.string()}, kBadUsage);
  EXPECT_FALSE(std::filesystem::exists(mended_));
}

}  // namespace
}  // namespace oos
