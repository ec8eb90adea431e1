#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <string>

#include "bus/log/compare_mcap.hpp"
#include "bus/log/mcap_indexed_reader.hpp"
#include "bus/log/mcap_reader.hpp"
#include "bus/log/mcap_writer.hpp"
#include "bus/log/merge_mcap.hpp"

namespace bus::log {
namespace {

constexpr std::uint32_t kNumMessages = 800;
constexpr std::size_t kMessageBytes = std::size_t{64} << 10;
// A third of the size of all messages.
constexpr std::size_t kSpareBytes = std::size_t{16} << 20;

std::size_t DataBytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t size = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
  statm >> size >> resident >> shared >> text >> library >> data;
  return data * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsMemoryLimited = false;  // sanitizers need more for themselves
#else
constexpr bool kIsMemoryLimited = true;
#endif

// Whether `body` holds in a process that may allocate kSpareBytes more than it has; with a sanitizer, whether it holds.
bool HoldsInLittleMemory(const std::function<bool()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    const rlim_t most = DataBytes() + kSpareBytes;
    const rlimit limit{most, most};
    if (kIsMemoryLimited && setrlimit(RLIMIT_DATA, &limit) != 0) _exit(2);
    bool holds = false;
    try {
      holds = body();
    } catch (const std::bad_alloc&) {
      _exit(3);
    }
    _exit(holds ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_NE(WEXITSTATUS(status), 3) << "out of memory";
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

class LargeFile : public ::testing::Test {
 protected:
  LargeFile() { std::filesystem::create_directories(folder_); }
  ~LargeFile() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::filesystem::path File(const std::string& name) const { return folder_ / name; }

  // `different`: number of a message with another payload.
  [[nodiscard]] std::filesystem::path Write(const std::string& name, bool is_closed,
                                            std::uint32_t different = 0) const {
    auto writer = std::move(*McapWriter::Create(File(name), {"", "test"}));
    EXPECT_TRUE(writer->Write(Metadata{"recording", {{"node", name}}}));
    const auto channel = writer->AddChannel(0, "a", "protobuf", {{"writer", "w"}});
    Message message{channel, 0, 0, 0, Bytes(kMessageBytes, 1)};
    for (std::uint32_t i = 1; i <= kNumMessages; ++i) {
      message.sequence = i;
      message.log_time_ns = message.publish_time_ns = 1000 * std::uint64_t{i};
      message.data[0] = i == different ? 2 : 1;
      EXPECT_TRUE(writer->Write(message));
    }
    EXPECT_TRUE(is_closed ? writer->Close(McapWriter::ToDisk::kLater) : writer->Flush());
    return File(name);
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("large_file_test" + std::to_string(::getpid()));
};

TEST_F(LargeFile, IsReadWithoutHoldingItInMemory) {
  const auto file = Write("a.mcap", true);
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    std::uint32_t count = 0;
    return ReadMcap(file, [&](const Channel&, const Message&) { ++count; }) && count == kNumMessages;
  }));
}

TEST_F(LargeFile, IsRecoveredWithoutHoldingItInMemory) {
  const auto whole = Write("whole.mcap", true);
  const auto open = Write("open.mcap", false);
  std::filesystem::resize_file(open, std::filesystem::file_size(open) - kMessageBytes / 2);
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    const auto recovery = RecoverMcap(whole, File("1.mcap"));
    return recovery && recovery->was_whole && recovery->num_messages == kNumMessages;
  }));
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    const auto recovery = RecoverMcap(open, File("2.mcap"));
    return recovery && !recovery->was_whole && recovery->num_messages == kNumMessages - 1;
  }));
}

TEST_F(LargeFile, IsComparedWithoutHoldingItInMemory) {
  const auto a = Write("a.mcap", true);
  const auto b = Write("b.mcap", false, 700);
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    const auto comparison = CompareMcap(a, b);
    return comparison && comparison->first && comparison->first->sequence == 700 &&
           comparison->channels.at(0).num_different == 1 && comparison->channels.at(0).num_a == kNumMessages;
  }));
}

TEST_F(LargeFile, WhoseWriterDiedIsReadByTimeAndMergedWithoutHoldingItInMemory) {
  const auto a = Write("a.mcap", false);
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    auto reader = McapIndexedReader::Open(a);
    if (!reader || reader->has_index()) return false;
    std::uint32_t next = 300;
    const auto done = reader->ReadMessages(
        [&](const Channel&, const Message& message) { return message.sequence == next && ++next > 0; }, 300'000,
        500'000);
    return done && next == 500;
  }));
  EXPECT_TRUE(HoldsInLittleMemory([&] {
    const auto merge = MergeMcap({a}, File("merged.mcap"));
    return merge && merge->num_messages == kNumMessages && merge->incomplete.size() == 1;
  }));
}

// A file of an unfinished recovery would make the next recovery fail.
TEST_F(LargeFile, ARecoveryThatFailsLeavesNoFile) {
  const auto a = Write("a.mcap", true);
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 20, 1 << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    _exit(RecoverMcap(a, File("b.mcap")) ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "it reports more bytes than the limit allows";
  EXPECT_FALSE(std::filesystem::exists(File("b.mcap")));
}

}  // namespace
}  // namespace bus::log
