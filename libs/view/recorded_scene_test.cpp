#include "view/recorded_scene.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "bus/log/recorder.hpp"
#include "bus/wire/codec.hpp"
#include "view/scene_digest.hpp"

namespace view {
namespace {

constexpr std::int64_t kBegin_ns = 7'000'000'000;
constexpr int kTicks = 300;  // of 1 ms

// One body that physics moves along x, at 1 mm a tick.
scene::Scenario OneBody() {
  scene::Scenario scenario;
  scene::Object block;
  block.name = "block";
  block.owner = scene::Owner::kPhysics;
  scenario.objects.push_back(block);
  return scenario;
}

core::PhysicsState StateAt(int tick) {
  core::PhysicsState state;
  state.tick = static_cast<std::uint64_t>(tick);
  state.time_ns = tick * 1'000'000;
  state.bodies.resize(1);
  state.bodies[0].object = 0;
  state.bodies[0].X_WO.translation.x = 1e-3 * tick;
  return state;
}

std::string StepAt(int tick) {
  return "step_" + std::to_string(tick / 100);
}

class RecordedSceneTest : public testing::Test {
 protected:
  RecordedSceneTest() {
    auto recorder = std::move(*bus::log::Recorder::Create(file_, {}));
    bus::LatestCodec<core::PhysicsState> codec;
    std::vector<std::uint8_t> bytes(2000);
    for (int tick = 0; tick <= kTicks; ++tick) {
      bus::Observation seen;
      seen.writer = "physics_node";
      seen.sequence = static_cast<std::uint64_t>(tick + 1);
      seen.received_ns = kBegin_ns + tick * 1'000'000;
      seen.topic = bus::kPhysicsStateTopic;
      seen.type = bus::MessageType::kPhysicsState;
      const std::size_t size = codec.Encode(StateAt(tick), 0, 1000, bytes.data(), bytes.size());
      seen.payload.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_TRUE(recorder->Add(seen));
      if (tick % 100 != 0) continue;
      core::LogicStatus status;
      status.step = StepAt(tick);
      seen.topic = bus::kLogicStatusTopic;
      seen.topic_class = bus::TopicClass::kState;
      seen.type = bus::MessageType::kLogicStatus;
      bus::EncodeState(status, &seen.payload);
      EXPECT_TRUE(recorder->Add(seen));
    }
    EXPECT_TRUE(recorder->Close(0, 0));
  }
  ~RecordedSceneTest() override { std::filesystem::remove(file_); }

  const scene::Scenario scenario_ = OneBody();
  const std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) / ("recorded_scene_" + std::to_string(getpid()) + ".mcap");
};

TEST_F(RecordedSceneTest, ShowsWhatAViewerShowsThatHasGotTheMessagesUpToThatTime) {
  auto recorded = RecordedScene::Open(file_, scenario_);
  ASSERT_TRUE(recorded) << recorded.error().detail;
  EXPECT_NEAR((*recorded)->duration_s(), 0.3, 1e-9);
  SceneMirror live(scenario_);
  for (const int tick : {0, 1, 99, 100, 250, 300}) {
    core::LogicStatus status;
    status.step = StepAt(tick);
    live.Apply(status);
    live.Apply(StateAt(tick));
    ASSERT_TRUE((*recorded)->GoTo(1e-3 * tick));
    const Scene& scene = (*recorded)->scene();
    EXPECT_EQ(SceneDigest(scene), SceneDigest(live.scene())) << tick;
    EXPECT_DOUBLE_EQ(scene.instances[0].X_WM.translation.x, 1e-3 * tick);
    EXPECT_EQ(scene.step, StepAt(tick));
    EXPECT_EQ(scene.time_ns, tick * 1'000'000);
  }
}

TEST_F(RecordedSceneTest, ATimeShowsTheSameSceneWhateverWasShownBefore) {
  auto stepwise = RecordedScene::Open(file_, scenario_);
  auto direct = RecordedScene::Open(file_, scenario_);
  ASSERT_TRUE(stepwise && direct);
  for (double t_s = 0.0; t_s < 0.3; t_s += 1.0 / 30.0) ASSERT_TRUE((*stepwise)->GoTo(t_s));
  ASSERT_TRUE((*stepwise)->GoTo(0.12));  // back again
  ASSERT_TRUE((*direct)->GoTo(0.12));
  EXPECT_DOUBLE_EQ((*direct)->scene().instances[0].X_WM.translation.x, 0.12);
  EXPECT_EQ(SceneDigest((*stepwise)->scene()), SceneDigest((*direct)->scene()));
}

TEST_F(RecordedSceneTest, ATimeBeyondTheEndIsRefusedWithTheLength) {
  auto recorded = RecordedScene::Open(file_, scenario_);
  ASSERT_TRUE(recorded);
  EXPECT_TRUE((*recorded)->CheckTime(0.3));
  const auto beyond = (*recorded)->CheckTime(0.31);
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().detail.find("0.300 s long"), std::string::npos) << beyond.error().detail;
}

TEST_F(RecordedSceneTest, AFileWithoutAnyPoseIsRefused) {
  const std::filesystem::path empty = file_.string() + ".empty";
  ASSERT_TRUE((*bus::log::Recorder::Create(empty, {}))->Close(0, 0));
  const auto recorded = RecordedScene::Open(empty, scenario_);
  ASSERT_FALSE(recorded);
  EXPECT_NE(recorded.error().detail.find("holds nothing that a viewer shows"), std::string::npos);
  std::filesystem::remove(empty);
}

}  // namespace
}  // namespace view
