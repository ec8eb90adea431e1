// Requirements on every visual node, whatever it draws with. The viewers are real processes; the test plays the rest of
// the system. A viewer publishes a digest of what it shows among its figures (view/scene_digest.hpp).

#include <fcntl.h>
#include <sys/stat.h>

#include <array>

#include "bus/accounts/reported_accounts.hpp"
#include "tests/viewer_support.hpp"
#include "tests/wall_frames.hpp"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

TEST_P(VisualNode, ShowsTheWholeSceneWhenItJoinsLate) {
  SetContent(2);
  ASSERT_TRUE(PublishUntil([] { return true; }));
  const std::string viewer = StartViewer();
  EXPECT_TRUE(Shows(viewer));
}

TEST_P(VisualNode, FollowsPosesLampsStepAndEnd) {
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  for (const int version : {2, 3}) {
    SetContent(version);
    EXPECT_TRUE(Shows(viewer)) << "version " << version;
  }
}

TEST_P(VisualNode, CanBeReplacedWhileTheOthersRun) {
  const std::string first = StartViewer();
  ASSERT_TRUE(Shows(first));
  const std::string second = StartViewer("-2");
  ASSERT_TRUE(Shows(second)) << "both side by side";
  End("", SIGKILL);
  SetContent(2);
  EXPECT_TRUE(Shows(second));
  shown_.clear();
  const std::string again = StartViewer("-3");
  EXPECT_TRUE(Shows(again));
}

TEST_P(VisualNode, SurvivesARestartOfPhysics) {
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  node_.reset();
  StartSystem();
  SetContent(3);
  shown_.clear();
  EXPECT_TRUE(Shows(viewer));
}

TEST_P(VisualNode, EndsCleanlyOnSigterm) {
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  End("", SIGTERM);
  EXPECT_TRUE(viewers_.children().front().exit->is_clean()) << viewers_.children().front().exit->Describe();
}

// It is on nobody's list of lost nodes.
TEST_P(VisualNode, SaysGoodbyeOnSigterm) {
  if (GetParam() == Kind::kText) GTEST_SKIP() << "an observer: nobody is told when it leaves";
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  End("", SIGTERM);
  EXPECT_TRUE(PublishUntil([&] { return HasHeard("node_left", viewer); }));
  EXPECT_FALSE(HasHeard("node_lost", viewer));
}

// Whoever stops it may not wait for its last pictures.
TEST_P(VisualNode, WritesItsFiguresBeforeItsLastPictures) {
  if (!draws()) GTEST_SKIP() << "this viewer writes no files";
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  End("", SIGTERM);
  const auto written = [&](const char* file) { return std::filesystem::last_write_time(out_ / viewer / file); };
  EXPECT_LE(written("visual_node.json"), written("frames/step_1.png"));
  EXPECT_LE(written("latency_visual.csv"), written("frames/step_1.png"));
}

// A node that is on the bus and only draws would seem to be stalled, and lost when it is killed meanwhile. The picture
// is a pipe, which blocks whoever writes it until somebody reads.
TEST_P(VisualNode, LeavesTheBusBeforeItsLastPictures) {
  if (!draws()) GTEST_SKIP() << "this viewer writes no files";
  const std::filesystem::path pipe = out_ / "visual_node-piped" / "frames" / "step_1.png";
  std::filesystem::create_directories(pipe.parent_path());
  std::filesystem::remove(pipe);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string viewer = StartViewer("-piped");
  ASSERT_TRUE(Shows(viewer));
  ASSERT_EQ(kill(pid_of_[viewer], SIGTERM), 0);
  EXPECT_TRUE(PublishUntil([&] { return HasHeard("node_left", viewer); }));
  viewers_.Reap();
  EXPECT_TRUE(viewers_.IsRunning(viewer));
  const int picture = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  End("-piped", SIGTERM);
  close(picture);
  EXPECT_TRUE(viewers_.children().front().exit->is_clean()) << viewers_.children().front().exit->Describe();
}

// Operator and teacher: each has its own view of the run, and no message is lost between all these ends without being
// counted.
TEST_P(VisualNode, ShowsAnotherViewThanTheOneBesideIt) {
  if (!draws()) GTEST_SKIP() << "this viewer has one view, or its views are those of its pages";
  const std::string first = StartViewer("-operator", {"--view", "gripper"});
  const std::string second = StartViewer("-teacher", {"--layout", "overview | above", "--stereo", "top_bottom"});
  ASSERT_TRUE(Shows(first));
  ASSERT_TRUE(Shows(second));
  SetContent(2);
  EXPECT_TRUE(Shows(first));
  EXPECT_TRUE(Shows(second));
  bus::NodeOptions auditor;
  auditor.name = "oos-auditor";
  auditor.registry = registry_->endpoint();
  auditor.session = kSession;
  auditor.is_encrypted = false;
  auditor.is_observer = true;
  const auto books = bus::Node::Create(auditor);
  ASSERT_TRUE(books) << books.error().detail;
  ASSERT_TRUE((*books)->Start());
  bus::ReportedAccounts accounts;
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  ASSERT_TRUE(PublishUntil([&] {
    (*books)->Poll();
    accounts.Update((*books)->Peers());
    return accounts.num_compared() > 10 &&
           core::MonotonicNow_ns() - begin_ns > 3 * bus::ReportedAccounts::kCompareAfter_ns;
  }));
  EXPECT_TRUE(accounts.Disagreements().empty()) << accounts.Disagreements().front();
  ASSERT_TRUE(node_->Emit({core::MonotonicNow_ns(), "physics_node", "screenshot", "now"}));
  const auto picture = [&](const std::string& viewer) { return out_ / viewer / "now.png"; };
  ASSERT_TRUE(PublishUntil(
      [&] { return std::filesystem::exists(picture(first)) && std::filesystem::exists(picture(second)); }));
  End("-operator", SIGTERM);
  End("-teacher", SIGTERM);
  const auto content = [&](const std::string& viewer) {
    std::ifstream in(picture(viewer), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_NE(content(first), content(second));
  EXPECT_GT(std::min(content(first).size(), content(second).size()), 500u) << "not blank";
}

// A room of three walls, each a process.
class Walls : public VisualNode {
 protected:
  std::string StartWall(const std::string& wall) {
    const std::map<std::string, std::string> screens = {{"left", "-1 -1 -1  -1 1 -1  -1 -1 1"},
                                                        {"front", "-1 1 -1  1 1 -1  -1 1 1"},
                                                        {"right", "1 1 -1  1 -1 -1  1 1 1"}};
    return StartViewer("-" + wall, {"--room", "cave", "--walls", "front,left,right", "--wall", wall, "--screen",
                                    screens.at(wall), "--head", "operator"});
  }
  [[nodiscard]] bool AreInStep(double number) {
    return PublishUntil([&] { return Figure("visual_node-front", "walls_in_step") == number; }).has_value();
  }

  [[nodiscard]] WallFrames FramesOf(const std::string& wall) const {
    return ReadWallFrames(out_ / ("visual_node-" + wall) / "walls.csv");
  }
};

TEST_P(Walls, ShowTheSameStateNoMoreThanAFrameApart) {
  for (const char* wall : {"front", "left", "right"}) ASSERT_TRUE(Shows(StartWall(wall)));
  ASSERT_TRUE(AreInStep(3));
  // More than the frames that are compared: on a busy machine a wall goes on by itself now and then.
  ASSERT_TRUE(DrawsMore("visual_node-right", 150));
  for (const char* wall : {"-right", "-left", "-front"}) End(wall, SIGTERM);
  const WallComparison walls({FramesOf("front"), FramesOf("left"), FramesOf("right")});
  ASSERT_GT(walls.num_common, 50u);
  RecordProperty("common_frames", std::to_string(walls.num_common));
  RecordProperty("frames_of_different_states", std::to_string(walls.num_other_states));
  RecordProperty("median_apart_ms", std::to_string(walls.apart_ms_at(0.5)));
  RecordProperty("p90_apart_ms", std::to_string(walls.apart_ms_at(0.9)));
  // How many milliseconds a frame takes is the machine's matter, and other tests run beside this one.
  EXPECT_EQ(walls.num_overtaken, 0u) << "no wall shows the next frame before all have shown this one";
  EXPECT_LE(walls.num_other_states, walls.num_common / 50) << "a wall may not yet have said which states it keeps";
}

// The left wall, played by the test: it says that it has drawn a frame some time after the first wall has drawn its
// own.
class SlowWall {
 public:
  static constexpr std::int64_t kSlower_ns = 20'000'000;  // well below Barrier::kPatience_ns

  core::Result<void> Join(const std::string& registry) {
    bus::NodeOptions options;
    options.name = "visual_node-left";
    options.registry = registry;
    options.session = kSession;
    options.is_encrypted = false;
    auto node = bus::Node::Create(options);
    if (!node) return tl::unexpected(node.error());
    node_ = std::move(*node);
    writer_ = node_->WriteLatest<core::WallState>(bus::WallStateTopic("cave", "left"));
    named_ = &node_->ReadLatest<core::WallFrame>(bus::WallFrameTopic("cave"));
    first_ = &node_->ReadLatest<core::WallState>(bus::WallStateTopic("cave", "front"));
    return node_->Start();
  }

  void Play() {
    node_->Poll();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (first_->value().frame > drawn_by_first_) {
      drawn_by_first_ = first_->value().frame;
      drawn_ns_ = now_ns;
    }
    if (named_->value().shown > said_.frame) {
      ++num_passed_;
      said_.frame = named_->value().shown;
    } else if (drawn_by_first_ > said_.frame && now_ns - drawn_ns_ >= kSlower_ns) {
      ++num_awaited_;
      said_.frame = drawn_by_first_;
    }
    writer_.Send(said_);
  }

  void Forget() { num_awaited_ = num_passed_ = 0; }
  [[nodiscard]] int num_awaited() const { return num_awaited_; }
  [[nodiscard]] int num_passed() const { return num_passed_; }  // all were to show it before this one had drawn it

 private:
  std::unique_ptr<bus::Node> node_;
  bus::LatestWriter<core::WallState> writer_;
  const bus::LatestReader<core::WallFrame>* named_ = nullptr;
  const bus::LatestReader<core::WallState>* first_ = nullptr;
  core::WallState said_;
  std::uint64_t drawn_by_first_ = 0;
  std::int64_t drawn_ns_ = 0;
  int num_awaited_ = 0, num_passed_ = 0;
};

TEST_P(Walls, AwaitTheSlowestOfThem) {
  SlowWall left;
  ASSERT_TRUE(left.Join(registry_->endpoint()));
  StartWall("front");
  ASSERT_TRUE(PublishUntil([&] {
    left.Play();
    return Figure("visual_node-front", "walls_in_step") == 2;
  }));
  left.Forget();
  ASSERT_TRUE(PublishUntil([&] {
    left.Play();
    return left.num_awaited() + left.num_passed() >= 50;
  }));
  // On a busy machine a wall may seem to be gone for a moment.
  EXPECT_LE(left.num_passed(), 5);
}

TEST_P(Walls, GoOnWithoutADeadWallAndTakeItInAgain) {
  for (const char* wall : {"front", "left", "right"}) ASSERT_TRUE(Shows(StartWall(wall)));
  ASSERT_TRUE(AreInStep(3));
  End("-left", SIGKILL);
  EXPECT_TRUE(AreInStep(2)) << "the others do not wait for it";
  EXPECT_TRUE(DrawsMore("visual_node-right", 10));
  // The first wall, too: the others go on by themselves.
  End("-front", SIGKILL);
  EXPECT_TRUE(DrawsMore("visual_node-right", 10));
  SetContent(2);
  EXPECT_TRUE(Shows("visual_node-right"));
  shown_.clear();
  StartWall("left");
  StartWall("front");
  EXPECT_TRUE(AreInStep(3));
}

INSTANTIATE_TEST_SUITE_P(Viewers, Walls, testing::Values(Kind::kOpenGl, Kind::kRays),
                         [](const auto& test) { return test.param == Kind::kOpenGl ? "OpenGl" : "Rays"; });

// A robot's camera for whoever processes pictures: the client of clients/python in a session of this test.
TEST_P(VisualNode, GivesAPythonClientTheImagesOfACamera) {
  if (!draws()) GTEST_SKIP() << "this viewer draws no pictures";
  const std::string viewer = StartViewer();
  ASSERT_TRUE(Shows(viewer));
  const std::filesystem::path clients = std::filesystem::path(VR_OOS_SOURCE_DIR) / "clients" / "python";
  process::Command client{.name = "client",
                          .program = "/usr/bin/python3",
                          .arguments = {clients / "example_camera.py", "overview", "5", "3"},
                          .environment = {{"XDG_RUNTIME_DIR", out_.string()},
                                          {"PYTHONDONTWRITEBYTECODE", "1"},
                                          {"PYTHONPATH", std::string(VR_OOS_BINARY_DIR) + "/clients/stubs"}},
                          .log = out_ / "client.log",
                          .folder = out_};
  std::filesystem::create_directories(out_ / "vr_oos");
  std::filesystem::permissions(out_ / "vr_oos", std::filesystem::perms::owner_all);
  std::ofstream(out_ / "vr_oos" / "session.json")
      << R"({"registry": ")" << registry_->endpoint() << R"(", "session": ")" << kSession << "\"}";
  ASSERT_TRUE(viewers_.Spawn(client).has_value());
  ASSERT_TRUE(PublishUntil([&] {
    viewers_.Reap();
    return !viewers_.IsRunning("client");
  }));
  EXPECT_TRUE(viewers_.children().back().exit->is_clean()) << "see " << client.log;
  std::ifstream picture(out_ / "camera.ppm", std::ios::binary);
  std::string kind;
  int width = 0, height = 0, most = 0;
  picture >> kind >> width >> height >> most;
  picture.get();
  const std::string rgb(std::istreambuf_iterator<char>(picture), {});
  EXPECT_EQ(kind, "P6");
  ASSERT_EQ(rgb.size(), std::size_t{3} * width * height);
  std::set<std::string> colours;
  for (std::size_t k = 0; k < rgb.size(); k += 3) colours.insert(rgb.substr(k, 3));
  EXPECT_GT(colours.size(), 100u) << "lit parts, not an empty picture";
}

// `oos view --video`: the session goes on, and its film is a film.
TEST_P(VisualNode, IsFilmedWhileItShowsTheSession) {
  if (!draws()) GTEST_SKIP() << "only a window is filmed";
  if (!process::RunHere({"ffmpeg", "-version"})) GTEST_SKIP() << "encoding needs ffmpeg";
  const std::string film = out_ / "film.mp4", raw = out_ / "film.rgb";
  process::Command view{
      .name = "view",
      .program = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin" / "oos",
      .arguments = {"view", scenario_.file.string(), "--video", film, "--headless", "--size", "96x64", "--registry",
                    registry_->endpoint(), "--session", std::to_string(kSession), "--no_encryption"},
      .environment = {},
      .log = out_ / "view.log",
      .folder = out_};
  if (GetParam() == Kind::kRays) view.arguments.insert(view.arguments.end(), {"--rays", "1"});
  const auto pid = viewers_.Spawn(view);
  ASSERT_TRUE(pid.has_value());
  const std::string viewer = "visual_node-" + std::to_string(*pid);
  ASSERT_TRUE(PublishUntil([&] { return Figure(viewer, "frames") > 20.0; }));
  kill(*pid, SIGINT);
  ASSERT_TRUE(PublishUntil([&] {
    viewers_.Reap();
    return !viewers_.IsRunning("view");
  }));
  EXPECT_TRUE(viewers_.children().back().exit->is_clean()) << "see " << view.log;
  const auto decoded =
      process::RunHere({"ffmpeg", "-loglevel", "error", "-y", "-i", film, "-f", "rawvideo", "-pix_fmt", "rgb24", raw});
  ASSERT_TRUE(decoded && decoded->is_good());
  std::ifstream in(raw, std::ios::binary);
  const std::string rgb(std::istreambuf_iterator<char>(in), {});
  constexpr std::size_t kFrame = std::size_t{3} * 96 * 64;
  ASSERT_EQ(rgb.size() % kFrame, 0u);
  ASSERT_GT(rgb.size() / kFrame, 0u);
  std::set<std::string> colours;
  for (std::size_t k = rgb.size() - kFrame; k < rgb.size(); k += 3) colours.insert(rgb.substr(k, 3));
  EXPECT_GT(colours.size(), 100u) << "lit parts, not an empty picture";
}

std::string NameOf(const testing::TestParamInfo<Kind>& info) {
  constexpr std::array kNames = {"OpenGl", "Rays", "Text", "Page"};
  return kNames[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Viewers, VisualNode, testing::Values(Kind::kOpenGl, Kind::kRays, Kind::kText, Kind::kPage),
                         NameOf);

}  // namespace
}  // namespace system_tests
