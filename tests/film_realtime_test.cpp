// The film that a run leaves of itself: `oos run`, as a person starts it. Real time: beside other tests a viewer joins
// late, and its film is shorter than the run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/clock.hpp"
#include "tests/support/film.hpp"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

constexpr int kPoll_ms = 100;

class Film : public testing::Test {
 protected:
  void SetUp() override {
    const char* display = std::getenv("DISPLAY");
    if (display == nullptr || *display == '\0') GTEST_SKIP() << "a window needs a display";
    if (!process::RunHere({"ffprobe", "-version"})) GTEST_SKIP() << "a film needs ffmpeg";
    std::filesystem::remove_all(out_);
  }
  ~Film() override { std::filesystem::remove_all(out_); }

  [[nodiscard]] std::vector<std::string> Words(const std::string& seconds, std::vector<std::string> more) const {
    std::vector<std::string> words = {
        VR_OOS_BINARY_DIR "/bin/oos", "run", "touch", "--duration", seconds, "--out", out_.string(), "--rt", "off"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] process::Answer Run(const std::string& seconds, const std::vector<std::string>& more = {}) const {
    return process::RunHere(Words(seconds, more), "", 200.0).value_or(process::Answer{});
  }
  [[nodiscard]] std::string Read(const char* file) const {
    std::ifstream in(out_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] bool HasFilm() const { return std::filesystem::exists(out_ / "film.mp4"); }

  const std::filesystem::path out_ = std::filesystem::path(testing::TempDir()) / ("film_" + std::to_string(getpid()));
};

// The arm moves from the first second on, so pictures that are a second apart differ.
TEST_F(Film, ARunInAWindowLeavesOneOfItsWholeLengthInItsPage) {
  const process::Answer run = Run("4");
  EXPECT_THAT(run.out, HasSubstr("limit of 4 s reached"));
  ASSERT_TRUE(HasFilm()) << run.out << run.err;
  const FilmFacts film = ReadFilm(out_ / "film.mp4");
  EXPECT_EQ(film.kind, "video");
  const double ran_s = nlohmann::json::parse(Read("report.json")).at("seconds");
  // The first step begins when the nodes are ready; what the viewer got is kept 30 times a second.
  EXPECT_NEAR(film.seconds, ran_s, 0.5);
  EXPECT_NEAR(film.pictures, film.seconds * 20.0, 1.0);
  ASSERT_GE(film.seconds, 3.0);
  EXPECT_GT(film.least_colours, 100u) << "an empty picture";
  for (std::size_t second = 1; second < static_cast<std::size_t>(film.seconds); ++second) {
    EXPECT_TRUE(film.Differ(20 * (second - 1), 20 * second)) << "nothing moves from " << second - 1 << " s on";
  }
  const std::string page = Read("report.html");
  EXPECT_NE(page.find("<video"), std::string::npos);
  EXPECT_GT(page.size(), std::filesystem::file_size(out_ / "film.mp4")) << "the film is in the page";
}

TEST_F(Film, IsNotMadeOfARunWithoutAWindowUnlessAskedFor) {
  EXPECT_THAT(Run("1", {"--headless"}).out, HasSubstr("'oos report' adds a film"));
  EXPECT_FALSE(HasFilm());
  EXPECT_THAT(Run("1", {"--headless", "--film"}).out, HasSubstr("film in "));
  EXPECT_TRUE(HasFilm());
}

TEST_F(Film, IsNotMadeWhereItIsDeclined) {
  EXPECT_THAT(Run("1", {"--no_film"}).out, HasSubstr("'oos report' adds a film"));
  EXPECT_FALSE(HasFilm());
}

// SIGTERM, which only `oos` gets.
TEST_F(Film, ThatIsInterruptedLeavesReportAndPage) {
  const auto child = process::PipedChild::Start(Words("4", {}));
  ASSERT_TRUE(child);
  const std::int64_t end_ns = core::MonotonicNow_ns() + 120 * core::kNanosecondsPerSecond;
  bool is_told = false;
  while (!(*child)->has_ended() && core::MonotonicNow_ns() < end_ns) {
    process::WaitForAny({child->get()}, kPoll_ms);
    (*child)->Poll();
    if (is_told || (*child)->out().find("making the film") == std::string::npos) continue;
    kill((*child)->pid(), SIGTERM);
    is_told = true;
  }
  EXPECT_TRUE(is_told) << (*child)->out() << (*child)->err();
  ASSERT_TRUE((*child)->has_ended());
  EXPECT_THAT((*child)->out(), HasSubstr("no video: interrupted"));
  EXPECT_FALSE(HasFilm());
  const std::string page = Read("report.html");
  EXPECT_NE(page.find("limit of 4 s reached"), std::string::npos);
  EXPECT_EQ(page.find("<video"), std::string::npos);
}

}  // namespace
}  // namespace system_tests
