// A run that is longer than its film.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/support/film.hpp"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

// Nobody moves the hand, so the run lasts as long as it may; the film's 400 pictures take minutes.
TEST(FilmOfALongRun, IsATimeLapseOfTwentySeconds) {
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') GTEST_SKIP() << "a window needs a display";
  if (!process::RunHere({"ffprobe", "-version"})) GTEST_SKIP() << "a film needs ffmpeg";
  const auto out = std::filesystem::path(testing::TempDir()) / ("long_film_" + std::to_string(getpid()));
  const auto run = process::RunHere({VR_OOS_BINARY_DIR "/bin/oos", "run", "module_replacement", "--duration", "40",
                                     "--rt", "off", "--out", out.string()},
                                    "", 900.0);
  ASSERT_TRUE(run) << run.error().detail;
  const FilmFacts film = ReadFilm(out / "film.mp4");
  EXPECT_EQ(film.kind, "video") << run->out << run->err;
  EXPECT_NEAR(film.seconds, 20.0, 0.1);
  EXPECT_NEAR(film.pictures, 400.0, 2.0);
  EXPECT_GT(film.least_colours, 100u) << "an empty picture";
  EXPECT_TRUE(film.Differ(0, 200));
  EXPECT_TRUE(film.Differ(200, 390));
  std::filesystem::remove_all(out);
}

}  // namespace
}  // namespace system_tests
