// Requirements on every visual node, whatever it draws with. The viewers are real processes; the test plays the rest of
// the system. A viewer publishes a digest of what it shows among its figures (view/scene_digest.hpp).

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "bus/accounts/reported_accounts.hpp"
#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "bus/wire/codec.hpp"
#include "core/clock.hpp"
#include "tests/support.hpp"
#include "tests/wall_frames.hpp"
#include "tools/process/group.hpp"
#include "view/scene_digest.hpp"
#include "view/scene_mirror.hpp"

namespace system_tests {
namespace {

constexpr std::int64_t kPatience_ns = 60 * core::kNanosecondsPerSecond;
constexpr std::int64_t kPeriod_ns = 2'000'000;
constexpr std::uint64_t kSession = 4711;

enum class Kind { kOpenGl, kRays, kText, kPage };  // kPage: scene_stream, which the page draws

constexpr int kRayWorkers = 2;

// All messages that a viewer shows, with different values in every version.
struct ShownContent {
  core::PhysicsState state;
  std::vector<core::HapticProxy> proxies;
  std::vector<core::SheetState> sheets;
  core::LogicStatus status;

  ShownContent(const scene::Scenario& scenario, int version) {
    const glm::dvec3 shift(0.01 * version, -0.02 * version, 0.003 * version);
    for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
      const scene::Object& object = scenario.objects[i];
      const auto index = static_cast<std::uint16_t>(i);
      if (object.owner == scene::Owner::kPhysics) {
        const glm::dquat turn = glm::angleAxis(0.1 * version, glm::dvec3(0, 0, 1));
        state.bodies.push_back({index, {turn, object.X_WO.translation + shift}, {}});
      }
      if (object.is_lamp) status.lamps.push_back({index, 0.1f * static_cast<float>(version), 0.5f, 0.25f});
      if (!object.sheet) continue;
      core::SheetState sheet;
      sheet.object = index;
      sheet.num_columns = static_cast<std::uint16_t>(object.sheet->cells_x + 1);
      const auto count = static_cast<std::size_t>((object.sheet->cells_x + 1) * (object.sheet->cells_y + 1));
      for (std::size_t k = 0; k < count; ++k) {
        sheet.p_W.push_back(glm::vec3(0.01f * static_cast<float>(k % 10), 0.1f, 0.02f * static_cast<float>(version)));
      }
      sheets.push_back(sheet);
    }
    for (std::size_t i = 0; i < scenario.devices.size(); ++i) {
      core::HapticProxy proxy;
      proxy.role_index = static_cast<std::uint8_t>(i);
      proxy.X_WD =
          proxy.X_WC = {scenario.devices[i].X_WD_start.rotation, scenario.devices[i].X_WD_start.translation + shift};
      proxy.opening_m = scenario.devices[i].opening_start_m;
      proxies.push_back(proxy);
    }
    status.step = "step_" + std::to_string(version);
    status.hint = "hint";
    status.is_final = version == 3;
  }

  [[nodiscard]] double Digest(const scene::Scenario& scenario) const {
    view::SceneMirror mirror(scenario);
    mirror.Apply(state);
    for (const core::HapticProxy& proxy : proxies) mirror.Apply(proxy);
    for (const core::SheetState& sheet : sheets) mirror.Apply(sheet);
    mirror.Apply(status);
    return static_cast<double>(view::SceneDigest(mirror.scene()));
  }
};

class VisualNode : public testing::TestWithParam<Kind> {
 protected:
  static bool draws() { return GetParam() == Kind::kOpenGl || GetParam() == Kind::kRays; }

  void SetUp() override {
    if (draws() && std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "a viewer that draws needs a display";
    auto registry =
        bus::Registry::Create({.endpoint = "tcp://127.0.0.1:0", .session = kSession, .is_encrypted = false});
    ASSERT_TRUE(registry.has_value()) << registry.error().detail;
    registry_ = std::move(*registry);
    out_ = std::filesystem::path(testing::TempDir()) / ("viewers-" + std::to_string(getpid()));
    std::filesystem::create_directories(out_);
    StartSystem();
  }

  // Starts one node that plays physics_node, haptic_node and logic_node.
  void StartSystem() {
    bus::NodeOptions options;
    options.name = "physics_node";
    options.registry = registry_->endpoint();
    options.session = kSession;
    options.is_encrypted = false;
    auto node = bus::Node::Create(options);
    ASSERT_TRUE(node.has_value()) << node.error().detail;
    node_ = std::move(*node);
    physics_ = node_->WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
    proxies_.clear();
    sheets_.clear();
    for (const scene::Device& device : scenario_.devices) {
      proxies_.push_back(node_->WriteLatest<core::HapticProxy>(bus::HapticProxyTopic(device.role)));
    }
    for (const scene::Object& object : scenario_.objects) {
      if (object.sheet) sheets_.push_back(node_->WriteLatest<core::SheetState>(bus::SheetTopic(object.name)));
    }
    logic_ = node_->WriteState<core::LogicStatus>(bus::kLogicStatusTopic);
    node_->ReadEvents();
    node_->Observe("figures/*");
    const auto started = node_->Start();
    ASSERT_TRUE(started.has_value()) << started.error().detail;
    SetContent(1);
  }

  // Sets what viewers must show from now on. The procedure's state is sent once, as by logic_node: the bus retains it.
  void SetContent(int version) {
    content_ = std::make_unique<ShownContent>(scenario_, version);
    wanted_ = content_->Digest(scenario_);
    ASSERT_TRUE(logic_.Set(content_->status));
  }

  // Returns the name that it has on the bus.
  std::string StartViewer(const std::string& suffix = "", const std::vector<std::string>& more = {}) {
    process::Command command;
    command.name = "visual_node" + suffix;
    command.log = out_ / (command.name + ".log");
    const std::filesystem::path bin = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
    command.arguments = {"--registry", registry_->endpoint(), "--session", std::to_string(kSession), "--no_encryption"};
    if (GetParam() == Kind::kText) {
      command.program = bin / "oos";
      command.arguments.insert(command.arguments.begin(), {"view", scenario_.file.string(), "--text"});
    } else if (GetParam() == Kind::kPage) {
      command.program = bin / "scene_stream";
      command.log = "/dev/null";  // its output is the page's input
      command.arguments.insert(command.arguments.end(),
                               {"--scenario", scenario_.file.string(), "--name", command.name});
    } else {
      command.program = bin / (GetParam() == Kind::kRays ? "rt_visual_node" : "visual_node");
      command.arguments.insert(command.arguments.end(),
                               {"--scenario", scenario_.file.string(), "--out", (out_ / command.name).string(),
                                "--size", "64x64", "--headless", "--name", command.name});
      command.arguments.insert(command.arguments.end(), more.begin(), more.end());
      std::filesystem::create_directories(out_ / command.name);
    }
    const auto pid = viewers_.Spawn(command);
    EXPECT_TRUE(pid.has_value());
    pid_of_[command.name] = pid.value_or(-1);
    if (GetParam() == Kind::kRays) StartWorkers(command.name);
    return GetParam() == Kind::kText ? "oos-view-" + std::to_string(pid.value_or(0)) : command.name;
  }

  // Who draw the tiles of that viewer.
  void StartWorkers(const std::string& viewer) {
    for (int seat = 1; seat <= kRayWorkers; ++seat) {
      process::Command command;
      command.name = "rt_worker-" + viewer + "-" + std::to_string(seat);
      command.log = out_ / (command.name + ".log");
      command.program = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin" / "rt_worker";
      command.arguments = {"--name",         command.name,
                           "--scenario",     scenario_.file.string(),
                           "--registry",     registry_->endpoint(),
                           "--session",      std::to_string(kSession),
                           "--out",          (out_ / viewer).string(),
                           "--no_encryption"};
      EXPECT_TRUE(viewers_.Spawn(command).has_value());
    }
  }

  // Publishes at 500 Hz until the condition holds; returns how long that took [s], or nothing if it never held.
  std::optional<double> PublishUntil(const std::function<bool()>& holds) {
    const std::int64_t start_ns = core::MonotonicNow_ns();
    while (core::MonotonicNow_ns() - start_ns < kPatience_ns) {
      ++content_->state.tick;
      physics_.Send(content_->state);
      for (std::size_t i = 0; i < proxies_.size(); ++i) proxies_[i].Send(content_->proxies[i]);
      for (std::size_t i = 0; i < sheets_.size(); ++i) sheets_[i].Send(content_->sheets[i]);
      node_->Wait(core::MonotonicNow_ns() + kPeriod_ns);
      bus::Observation seen;
      while (node_->PollObservation(&seen)) EXPECT_TRUE(bus::DecodeState(seen.payload, &shown_[seen.topic]));
      core::Event event;
      while (node_->PollEvent(&event)) {
      }
      if (holds()) return 1e-9 * static_cast<double>(core::MonotonicNow_ns() - start_ns);
    }
    return std::nullopt;
  }

  [[nodiscard]] bool ShowsTheContent(const std::string& viewer) {
    const double* digest = bus::FindFigure(shown_[bus::FiguresTopic(viewer)], view::kSceneDigestFigure);
    return digest != nullptr && *digest == wanted_;
  }
  // 0: not published yet.
  [[nodiscard]] double Figure(const std::string& viewer, const char* name) {
    const double* figure = bus::FindFigure(shown_[bus::FiguresTopic(viewer)], name);
    return figure != nullptr ? *figure : 0.0;
  }
  [[nodiscard]] bool DrawsMore(const std::string& viewer, double num_frames) {
    const double before = Figure(viewer, "frames");
    return PublishUntil([&] { return Figure(viewer, "frames") >= before + num_frames; }).has_value();
  }
  [[nodiscard]] bool Shows(const std::string& viewer) {
    return PublishUntil([&] { return ShowsTheContent(viewer); }).has_value();
  }

  void End(const std::string& suffix, int signal) {
    ASSERT_EQ(kill(pid_of_["visual_node" + suffix], signal), 0);
    ASSERT_TRUE(PublishUntil([&] {
      viewers_.Reap();
      return !viewers_.IsRunning("visual_node" + suffix);
    }));
  }

  scene::Scenario scenario_ = Load("module_replacement");
  std::filesystem::path out_;
  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<bus::Node> node_;
  bus::LatestWriter<core::PhysicsState> physics_;
  std::vector<bus::LatestWriter<core::HapticProxy>> proxies_;
  std::vector<bus::LatestWriter<core::SheetState>> sheets_;
  bus::StateWriter<core::LogicStatus> logic_;
  std::unique_ptr<ShownContent> content_;
  double wanted_ = 0.0;
  std::map<std::string, bus::Figures> shown_;  // by topic
  std::map<std::string, pid_t> pid_of_;
  process::Group viewers_;
};

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
  ASSERT_TRUE(DrawsMore("visual_node-right", 60));
  for (const char* wall : {"-right", "-left", "-front"}) End(wall, SIGTERM);
  const WallComparison walls({FramesOf("front"), FramesOf("left"), FramesOf("right")});
  ASSERT_GT(walls.num_common, 50u);
  RecordProperty("common_frames", std::to_string(walls.num_common));
  RecordProperty("frames_of_different_states", std::to_string(walls.num_other_states));
  RecordProperty("median_apart_ms", std::to_string(walls.apart_ms_at(0.5)));
  RecordProperty("p90_apart_ms", std::to_string(walls.apart_ms_at(0.9)));
  EXPECT_EQ(walls.num_overtaken, 0u);
  EXPECT_LE(walls.num_other_states, walls.num_common / 50) << "a datagram may be lost";
  EXPECT_LE(walls.apart_ms_at(0.5), 1e3 / 30.0) << "a frame at 30 per second";
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

INSTANTIATE_TEST_SUITE_P(Viewers, Walls, testing::Values(Kind::kOpenGl), [](const auto&) { return "OpenGl"; });

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

std::string NameOf(const testing::TestParamInfo<Kind>& info) {
  constexpr std::array kNames = {"OpenGl", "Rays", "Text", "Page"};
  return kNames[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Viewers, VisualNode, testing::Values(Kind::kOpenGl, Kind::kRays, Kind::kText, Kind::kPage),
                         NameOf);

}  // namespace
}  // namespace system_tests
