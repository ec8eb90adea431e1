// Viewers whose workers are killed, stopped and started, and viewers that take each other's place.

#include "tests/viewer_support.hpp"

namespace system_tests {
namespace {

// Workers as processes, while everything moves, so that whatever happens to one happens in the middle of a picture.
class RayWorkers : public VisualNode {
 protected:
  static constexpr double kFrames = 20.0;

  // How long so many pictures take [s].
  double TimeOfFrames() {
    const double before = Figure(kViewer, "frames");
    const auto seconds = PublishUntil([&] { return Figure(kViewer, "frames") >= before + kFrames; });
    EXPECT_TRUE(seconds) << "the picture stands still";
    return seconds.value_or(1e9);
  }
  // What has happened costs no more than a second beyond what as many pictures take afterwards.
  void ExpectRateIsBack(const char* after) {
    const double at_once_s = TimeOfFrames(), later_s = TimeOfFrames();
    RecordProperty(std::string("lost_ms_") + after, std::to_string(1e3 * (at_once_s - later_s)));
    std::printf("%s: %.0f pictures in %.2f s, then in %.2f s\n", after, kFrames, at_once_s, later_s);
    EXPECT_LE(at_once_s - later_s, 1.0) << after;
  }
  void Signal(int seat, int signal) { ASSERT_EQ(kill(pid_of_[WorkerName(kViewer, seat)], signal), 0); }
  // By the viewer's log, once it has ended.
  void ExpectAllFramesAreComplete() {
    std::ifstream in(out_ / (std::string(kViewer) + ".log"));
    std::string line;
    unsigned long long complete = 0, begun = 0;
    while (std::getline(in, line)) {
      if (std::sscanf(line.c_str(), "%llu of %llu frames complete", &complete, &begun) == 2) break;
    }
    EXPECT_GT(complete, 100u) << line;
    EXPECT_LE(begun - complete, 2u) << "those in flight at the end";
  }
  static constexpr const char* kViewer = "visual_node";
};

TEST_P(RayWorkers, MayDieStopAndJoinInTheMiddleOfAPicture) {
  ASSERT_TRUE(Shows(StartViewer()));
  moves_ = true;
  ASSERT_TRUE(DrawsMore(kViewer, kFrames));
  StartWorker(kViewer, 3);
  ExpectRateIsBack("joined");
  Signal(2, SIGSTOP);
  ExpectRateIsBack("stopped");
  Signal(1, SIGKILL);
  ExpectRateIsBack("killed");
  Signal(2, SIGCONT);
  ExpectRateIsBack("continued");
  Signal(3, SIGKILL);
  ExpectRateIsBack("second_killed");
  StartWorker(kViewer, 1);
  ExpectRateIsBack("in_its_seat_again");
  Signal(1, SIGKILL);
  Signal(2, SIGKILL);
  ExpectRateIsBack("all_killed");  // OpenGL draws then
  moves_ = false;
  SetContent(2);
  EXPECT_TRUE(Shows(kViewer));
  End("", SIGTERM);
  ExpectAllFramesAreComplete();
}

INSTANTIATE_TEST_SUITE_P(Viewers, RayWorkers, testing::Values(Kind::kRays), [](const auto&) { return "Rays"; });

class Replaced : public VisualNode {};

// While states come at their full rate. How long it takes is measured live by lab_tests_slow_test (Swap).
TEST_P(Replaced, IsReplacedByEachOtherOne) {
  if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "the other viewers need a display";
  std::string old_suffix;
  ASSERT_TRUE(Shows(StartViewer()));
  moves_ = true;
  int number = 1;
  for (const Kind kind : {Kind::kOpenGl, Kind::kRays, Kind::kText}) {
    for (const Kind next : {kind, GetParam()}) {
      ++number;
      const std::string suffix = "-" + std::to_string(number);
      const std::string viewer = StartViewer(next, suffix);
      const auto found = PublishUntil([&] { return shown_.count(bus::FiguresTopic(viewer)) != 0; });
      ASSERT_TRUE(found) << viewer;
      moves_ = false;
      SetContent(number);
      const auto whole = PublishUntil([&] { return ShowsTheContent(viewer); });
      ASSERT_TRUE(whole) << viewer;
      moves_ = true;
      std::printf("%s: %.2f s to its first figures, %.2f s to the whole scene\n", viewer.c_str(), *found, *whole);
      End(old_suffix, SIGKILL);
      old_suffix = suffix;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Viewers, Replaced, testing::Values(Kind::kOpenGl, Kind::kRays, Kind::kText), [](const auto& test) {
      return std::string(test.param == Kind::kOpenGl ? "OpenGl" : test.param == Kind::kRays ? "Rays" : "Text");
    });

}  // namespace
}  // namespace system_tests
