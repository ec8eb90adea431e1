#include "nodes/visual_node/receiver.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "bus/membership/registry.hpp"
#include "core/clock.hpp"
#include "view/recorded_scene.hpp"
#include "view/scene_digest.hpp"

namespace visual_node {
namespace {

constexpr std::int64_t kPatience_ns = 10 * core::kNanosecondsPerSecond;

// One free block and one hand that is a ball.
scene::Scenario SmallScenario() {
  scene::Scenario scenario;
  scenario.name = "small";
  for (const char* name : {"block", "ball"}) {
    scene::Object object;
    object.name = name;
    object.visual_mesh = std::string("/") + name;
    scenario.objects.push_back(object);
  }
  scenario.objects[0].owner = scene::Owner::kPhysics;
  scenario.objects[1].owner = scene::Owner::kHand;
  scenario.objects[1].part = scene::HandPart::kPalm;
  scenario.objects[1].role = 0;
  scene::Device device;
  device.role = "right";
  device.palm = 1;
  scenario.devices.push_back(device);
  return scenario;
}

class ReceiverTest : public testing::Test {
 protected:
  void SetUp() override {
    auto registry = bus::Registry::Create({.endpoint = "tcp://127.0.0.1:0", .session = 77, .is_encrypted = false});
    ASSERT_TRUE(registry) << registry.error().detail;
    registry_ = std::move(*registry);
    bus::NodeOptions options;
    options.name = "physics_node";
    options.registry = registry_->endpoint();
    options.session = 77;
    options.is_encrypted = false;
    auto node = bus::Node::Create(options);
    ASSERT_TRUE(node) << node.error().detail;
    peer_ = std::move(*node);
    physics_ = peer_->WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
    logic_ = peer_->WriteState<core::LogicStatus>(bus::kLogicStatusTopic);
    seen_ = &peer_->ReadState<core::CameraImage>(bus::CameraImageTopic("visual_node", "default"));
    ASSERT_TRUE(peer_->Start());
    options.name = "visual_node";
    const auto started = receiver_.Start(options);
    ASSERT_TRUE(started) << started.error().detail;
  }

  // Publishes state number k until the receiver's scene satisfies `is_seen`; false after kPatience_ns.
  template <typename Predicate>
  bool PublishUntil(Predicate is_seen) {
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
    while (core::MonotonicNow_ns() < deadline_ns) {
      core::PhysicsState state;
      state.tick = ++tick_;
      core::BodyState body;
      body.object = 0;
      body.X_WO.translation = {0.25, 0.0, 1e-6 * static_cast<double>(tick_)};
      state.bodies.push_back(body);
      const std::int64_t now_ns = core::MonotonicNow_ns();
      state.header.through_physics.id = core::MakeTraceId(0, tick_);
      state.header.through_physics.origin_ns = now_ns;
      state.header.through_physics.Add(core::Stage::kDeviceSample, now_ns);
      physics_.Send(state);
      peer_->Wait(now_ns + 1'000'000);
      if (receiver_.Update() && is_seen(receiver_.scene())) return true;
    }
    return false;
  }

  scene::Scenario scenario_ = SmallScenario();
  LatencyLog log_;
  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<bus::Node> peer_;
  bus::LatestWriter<core::PhysicsState> physics_;
  bus::StateWriter<core::LogicStatus> logic_;
  bus::StateReader<core::CameraImage>* seen_ = nullptr;
  std::uint64_t tick_ = 0;
  Receiver receiver_{scenario_, &log_};
};

TEST_F(ReceiverTest, AStateReachesTheSceneWithItsStamps) {
  ASSERT_TRUE(PublishUntil([](const view::Scene& scene) { return scene.instances[0].X_WM.translation.x > 0.2; }));
  const core::Trace& trace = receiver_.scene().through_physics;
  ASSERT_EQ(trace.stamps.size(), 3u);
  EXPECT_EQ(trace.stamps[1].stage, core::Stage::kVisualReceive);
  EXPECT_EQ(trace.stamps[2].stage, core::Stage::kVisualApply);
  EXPECT_LE(trace.stamps[0].offset_ns, trace.stamps[1].offset_ns);
  EXPECT_LE(trace.stamps[1].offset_ns, trace.stamps[2].offset_ns);
}

TEST_F(ReceiverTest, MeasuresEveryStateEvenWithoutAFrame) {
  // Nothing is drawn here; every state that arrives is applied and measured.
  ASSERT_TRUE(PublishUntil([&](const view::Scene&) { return receiver_.num_states() >= 50; }));
  receiver_.Stop();
  EXPECT_EQ(log_.state().count(), receiver_.num_states());
  EXPECT_EQ(log_.image().count(), 0u);
}

TEST_F(ReceiverTest, ReceivesTheStepAndAScreenshotRequest) {
  core::LogicStatus status;
  status.step = "cover";
  ASSERT_TRUE(logic_.Set(status));
  ASSERT_TRUE(PublishUntil([](const view::Scene& scene) { return scene.step == "cover"; }));
  core::Event event;
  event.source = "test";
  event.name = "screenshot";
  event.detail = "look";
  ASSERT_TRUE(peer_->Emit(event));
  std::vector<std::string> names;
  ASSERT_TRUE(PublishUntil([&](const view::Scene&) {
    for (const std::string& name : receiver_.TakeScreenshotRequests()) names.push_back(name);
    return !names.empty();
  }));
  EXPECT_EQ(names.front(), "look");
}

TEST_F(ReceiverTest, AParameterSwitchesAnOverlayAndHidesAPart) {
  ASSERT_TRUE(peer_->WaitForPeers({"visual_node"}, kPatience_ns));
  ASSERT_TRUE(peer_->SetParameter("visual_node", {"overlay.felt_force", 1.0}, kPatience_ns));
  ASSERT_TRUE(peer_->SetParameter("visual_node", {"hide.block", 1.0}, kPatience_ns));
  EXPECT_TRUE(receiver_.choices().has(view::Overlay::kFeltForce));
  EXPECT_TRUE(PublishUntil([](const view::Scene& scene) { return !scene.instances[0].is_visible; }));
  EXPECT_FALSE(peer_->SetParameter("visual_node", {"hide.nothing", 1.0}, kPatience_ns)) << "no such part";
  EXPECT_FALSE(peer_->SetParameter("visual_node", {"hide.block", 0.5}, kPatience_ns)) << "neither yes nor no";
  EXPECT_TRUE(receiver_.choices().objects[0].is_hidden);
}

TEST_F(ReceiverTest, ACamerasPictureIsATopicWhenItIsWanted) {
  ASSERT_TRUE(peer_->WaitForPeers({"visual_node"}, kPatience_ns));
  EXPECT_EQ(receiver_.image_rates_hz(), std::vector<double>{0.0});
  EXPECT_FALSE(peer_->SetParameter("visual_node", {"image.default.rate_hz", 30.0}, kPatience_ns)) << "too often";
  ASSERT_TRUE(peer_->SetParameter("visual_node", {"image.default.rate_hz", 2.5}, kPatience_ns));
  EXPECT_EQ(receiver_.image_rates_hz(), std::vector<double>{2.5});
  core::CameraImage image;
  image.width = CameraFeed::kTopicWidth;
  image.height = CameraFeed::kTopicHeight;
  image.rgb.assign(std::size_t{3} * CameraFeed::kTopicWidth * CameraFeed::kTopicHeight, '\xfe');
  receiver_.SendImage({0, image});
  ASSERT_TRUE(PublishUntil([&](const view::Scene&) { return seen_->has_value(); }));
  EXPECT_EQ(seen_->value().rgb, image.rgb) << "62 kB, none of it text";
}

TEST_F(ReceiverTest, TheRecordedSceneIsTheOneThatWasShown) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("receiver_" + std::to_string(getpid()) + ".mcap");
  receiver_.Stop();
  auto recorded_receiver = std::make_unique<Receiver>(scenario_, &log_);
  ASSERT_TRUE(recorded_receiver->Record(file));
  bus::NodeOptions options;
  options.name = "visual_node-2";
  options.registry = registry_->endpoint();
  options.session = 77;
  options.is_encrypted = false;
  ASSERT_TRUE(recorded_receiver->Start(options));
  core::LogicStatus status;
  status.step = "insert";
  ASSERT_TRUE(logic_.Set(status));
  core::PhysicsState state;
  state.bodies.push_back({0, {glm::dquat(1, 0, 0, 0), {0.5, 0.25, 0.125}}, {}});
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
  const auto is_shown = [&] {
    recorded_receiver->Update();
    const view::Scene& scene = recorded_receiver->scene();
    return scene.step == "insert" && scene.instances[0].X_WM.translation.x == 0.5;
  };
  // Longer than a period of the recording, so that the state is in it.
  for (std::int64_t shown_ns = 0; shown_ns < 2 * view::SceneRecorder::kPeriod_ns;) {
    ASSERT_LT(core::MonotonicNow_ns(), deadline_ns);
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    physics_.Send(state);
    peer_->Wait(begin_ns + 1'000'000);
    if (is_shown()) shown_ns += core::MonotonicNow_ns() - begin_ns;
  }
  const std::uint64_t shown = view::SceneDigest(recorded_receiver->scene());
  recorded_receiver->Stop();
  auto recorded = view::RecordedScene::Open(file, scenario_);
  ASSERT_TRUE(recorded) << recorded.error().detail;
  ASSERT_TRUE((*recorded)->GoTo((*recorded)->duration_s()));
  EXPECT_EQ(view::SceneDigest((*recorded)->scene()), shown);
  EXPECT_EQ((*recorded)->scene().step, "insert");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace visual_node
