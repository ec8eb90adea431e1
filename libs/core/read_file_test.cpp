#include "core/read_file.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace core {
namespace {

TEST(ReadFile, ReturnsEveryByte) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "read_file_test";
  const std::vector<std::uint8_t> bytes{0, 255, 10, 13, 0};
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), 5);
  EXPECT_EQ(ReadFile(file).value(), bytes);
  std::ofstream(file, std::ios::binary | std::ios::trunc);
  EXPECT_TRUE(ReadFile(file).value().empty());
  std::filesystem::remove(file);
}

TEST(ReadFile, RefusesAFolderAndAMissingFile) {
  EXPECT_EQ(ReadFile(testing::TempDir()).error().code, ErrorCode::kIo);
  EXPECT_EQ(ReadFile("/no/such/file").error().code, ErrorCode::kNotFound);
}

// fstat reports size 0 for it.
TEST(ReadFile, ReadsAFileInProc) {
  EXPECT_FALSE(ReadFile("/proc/self/cmdline").value().empty());
}

}  // namespace
}  // namespace core
