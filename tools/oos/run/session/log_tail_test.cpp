#include "tools/oos/run/session/log_tail.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace oos {
namespace {

TEST(LogTail, GivesTheLastWholeLineOnce) {
  const auto file = std::filesystem::temp_directory_path() / ("log_tail-" + std::to_string(getpid()));
  LogTail tail(file);
  EXPECT_EQ(tail.NewestLine(), "") << "before the file is there";
  std::ofstream log(file);
  log << "one\ntwo\nthr" << std::flush;
  EXPECT_EQ(tail.NewestLine(), "two");
  EXPECT_EQ(tail.NewestLine(), "");
  log << "ee\n" << std::flush;
  EXPECT_EQ(tail.NewestLine(), "three");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace oos
