#include "tools/oos/meshes/progress_line.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

namespace oos {
namespace {

using testing::HasSubstr;
using testing::Not;

void ReportTwoStages(std::FILE* stream, bool else_stages) {
  ProgressLine line("bolt", stream, else_stages);
  const vps::Progress progress = line.AsProgress();
  progress("bricks", 0.25);
  progress("bricks", 0.5);
  progress("bounds", 1.0);
}

std::string TextInFile(bool else_stages) {
  std::FILE* file = std::tmpfile();
  ReportTwoStages(file, else_stages);
  std::rewind(file);
  std::string text(200, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  return text;
}

TEST(ProgressLine, InAFileIsALineForEachStageOrNothing) {
  EXPECT_EQ(TextInFile(true), "  bricks\n  bounds\n");
  EXPECT_EQ(TextInFile(false), "");
}

TEST(ProgressLine, OnATerminalIsOneLineThatIsErasedAtTheEnd) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(grantpt(terminal), 0);
  ASSERT_EQ(unlockpt(terminal), 0);
  std::FILE* stream = std::fopen(ptsname(terminal), "w");
  ASSERT_NE(stream, nullptr);
  ReportTwoStages(stream, false);
  std::fclose(stream);
  // A read gives what has come so far: the text is whole once the closed terminal has no more.
  std::string text;
  char part[64];
  for (ssize_t size = 0; (size = read(terminal, part, sizeof part)) > 0;) {
    text.append(part, static_cast<std::size_t>(size));
  }
  close(terminal);
  EXPECT_THAT(text, HasSubstr("bolt: bricks  50 %"));
  EXPECT_THAT(text, HasSubstr("bolt: bounds 100 %"));
  EXPECT_THAT(text, Not(HasSubstr("\n")));
  EXPECT_TRUE(text.ends_with("\r\033[K"));
}

}  // namespace
}  // namespace oos
