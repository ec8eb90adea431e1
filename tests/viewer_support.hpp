#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
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
#include "tools/process/group.hpp"
#include "view/scene_digest.hpp"
#include "view/scene_mirror.hpp"

namespace system_tests {

inline constexpr std::int64_t kPatience_ns = 60 * core::kNanosecondsPerSecond;
inline constexpr std::int64_t kPeriod_ns = 2'000'000;
inline constexpr std::uint64_t kSession = 4711;

enum class Kind { kOpenGl, kRays, kText, kPage };  // kPage: scene_stream, which the page draws

inline constexpr int kRayWorkers = 2;

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
    return StartViewer(GetParam(), suffix, more);
  }
  std::string StartViewer(Kind kind, const std::string& suffix, const std::vector<std::string>& more = {}) {
    process::Command command;
    command.name = "visual_node" + suffix;
    command.log = out_ / (command.name + ".log");
    const std::filesystem::path bin = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
    command.arguments = {"--registry", registry_->endpoint(), "--session", std::to_string(kSession), "--no_encryption"};
    if (kind == Kind::kText) {
      command.program = bin / "oos";
      command.arguments.insert(command.arguments.begin(), {"view", scenario_.file.string(), "--text"});
    } else if (kind == Kind::kPage) {
      command.program = bin / "scene_stream";
      command.log = "/dev/null";  // its output is the page's input
      command.arguments.insert(command.arguments.end(),
                               {"--scenario", scenario_.file.string(), "--name", command.name});
    } else {
      command.program = bin / (kind == Kind::kRays ? "rt_visual_node" : "visual_node");
      command.arguments.insert(command.arguments.end(),
                               {"--scenario", scenario_.file.string(), "--out", (out_ / command.name).string(),
                                "--size", "64x64", "--headless", "--name", command.name});
      command.arguments.insert(command.arguments.end(), more.begin(), more.end());
      std::filesystem::create_directories(out_ / command.name);
    }
    const auto pid = viewers_.Spawn(command);
    EXPECT_TRUE(pid.has_value());
    pid_of_[command.name] = pid.value_or(-1);
    if (kind == Kind::kRays) StartWorkers(command.name);
    return kind == Kind::kText ? "oos-view-" + std::to_string(pid.value_or(0)) : command.name;
  }

  // Who draw the tiles of that viewer.
  void StartWorkers(const std::string& viewer) {
    for (int seat = 1; seat <= kRayWorkers; ++seat) StartWorker(viewer, seat);
  }
  void StartWorker(const std::string& viewer, int seat) {
    process::Command command;
    command.name = WorkerName(viewer, seat);
    command.log = out_ / (command.name + ".log");
    command.program = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin" / "rt_worker";
    command.arguments = {"--name",         command.name,
                         "--scenario",     scenario_.file.string(),
                         "--registry",     registry_->endpoint(),
                         "--session",      std::to_string(kSession),
                         "--out",          (out_ / viewer).string(),
                         "--no_encryption"};
    const auto pid = viewers_.Spawn(command);
    EXPECT_TRUE(pid.has_value());
    pid_of_[command.name] = pid.value_or(-1);
  }
  static std::string WorkerName(const std::string& viewer, int seat) {
    return "rt_worker-" + viewer + "-" + std::to_string(seat);
  }

  // Publishes at 500 Hz until the condition holds; returns how long that took [s], or nothing if it never held.
  std::optional<double> PublishUntil(const std::function<bool()>& holds) {
    const std::int64_t start_ns = core::MonotonicNow_ns();
    while (core::MonotonicNow_ns() - start_ns < kPatience_ns) {
      ++content_->state.tick;
      if (moves_) {
        const double phase = 0.02 * static_cast<double>(content_->state.tick);
        content_->state.bodies[0].X_WO.translation.z += 1e-3 * std::cos(phase);
      }
      physics_.Send(content_->state);
      for (std::size_t i = 0; i < proxies_.size(); ++i) proxies_[i].Send(content_->proxies[i]);
      for (std::size_t i = 0; i < sheets_.size(); ++i) sheets_[i].Send(content_->sheets[i]);
      node_->Wait(core::MonotonicNow_ns() + kPeriod_ns);
      bus::Observation seen;
      while (node_->PollObservation(&seen)) EXPECT_TRUE(bus::DecodeState(seen.payload, &shown_[seen.topic]));
      core::Event event;
      while (node_->PollEvent(&event)) heard_.push_back(event);
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

  [[nodiscard]] bool HasHeard(const std::string& event, const std::string& about) const {
    return std::any_of(heard_.begin(), heard_.end(),
                       [&](const core::Event& heard) { return heard.name == event && heard.detail == about; });
  }

  void End(const std::string& suffix, int signal) {
    ASSERT_EQ(kill(pid_of_["visual_node" + suffix], signal), 0);
    ASSERT_TRUE(PublishUntil([&] {
      viewers_.Reap();
      return !viewers_.IsRunning("visual_node" + suffix);
    }));
  }

  bool moves_ = false;  // each state is another one
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
  std::vector<core::Event> heard_;             // since the start
  std::map<std::string, bus::Figures> shown_;  // by topic
  std::map<std::string, pid_t> pid_of_;
  process::Group viewers_;
};

}  // namespace system_tests
