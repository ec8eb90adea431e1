#include "core/write_file.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "core/read_file.hpp"

namespace core {
namespace {

namespace fs = std::filesystem;

class WriteFileTest : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_ = fs::path(testing::TempDir()) / "write_file_test";
  fs::path file_ = folder_ / "a" / "b";
};

TEST_F(WriteFileTest, TheFileHasAllBytesAndNothingElseIsLeft) {
  const std::string bytes("a\0b\r\n", 5);
  ASSERT_TRUE(WriteFile(file_, bytes));
  const auto read = ReadFile(file_);
  ASSERT_TRUE(read);
  EXPECT_EQ(std::string(read->begin(), read->end()), bytes);
  EXPECT_EQ(std::distance(fs::directory_iterator(file_.parent_path()), fs::directory_iterator()), 1);
}

TEST_F(WriteFileTest, AReaderNeverSeesHalfOfWhatSeveralWrite) {
  ASSERT_TRUE(WriteFile(file_, std::string(100000, 'a')));
  std::atomic<int> num_writing{2};
  const auto write = [&](char letter) {
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(WriteFile(file_, std::string(100000, letter)));
    --num_writing;
  };
  std::thread first(write, 'a'), second(write, 'b');
  while (num_writing > 0) {
    const auto read = ReadFile(file_);
    EXPECT_TRUE(read);
    if (!read) continue;
    EXPECT_EQ(*read, std::vector<std::uint8_t>(100000, read->front()));
  }
  first.join();
  second.join();
}

TEST_F(WriteFileTest, NamesAFileThatCannotBeWritten) {
  const auto written = WriteFile("/proc/none/file", "x");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_NE(written.error().detail.find("/proc/none/file"), std::string::npos);
}

}  // namespace
}  // namespace core
