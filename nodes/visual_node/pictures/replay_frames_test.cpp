#include "nodes/visual_node/pictures/replay_frames.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "bus/log/recorder.hpp"
#include "bus/wire/codec.hpp"
#include "nodes/visual_node/pictures/shot.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"
#include "nodes/visual_node/testing/read_png.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

// The free block of the scenario `touch` flies away within half a second.
class ReplayFramesTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto scenario = scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/touch");
    ASSERT_TRUE(scenario);
    scenario_ = *scenario;
    options_.width = 160;
    options_.height = 90;
    options_.max_frames_per_s = 10.0;
    options_.pictures.recording = folder_ / "run.mcap";
    std::filesystem::create_directories(folder_);
    Record();
  }
  ~ReplayFramesTest() override { std::filesystem::remove_all(folder_); }

  void Record() const {
    auto recorder = std::move(*bus::log::Recorder::Create(options_.pictures.recording, {}));
    const bus::LatestCodec<core::PhysicsState> codec;
    std::vector<std::uint8_t> bytes(2000);
    for (int tick = 0; tick <= 500; ++tick) {
      core::PhysicsState state;
      state.time_ns = tick * 1'000'000;
      for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
        if (scenario_.objects[i].owner != scene::Owner::kPhysics) continue;
        state.bodies.push_back({static_cast<std::uint16_t>(i), scenario_.objects[i].X_WO, {}});
        state.bodies.back().X_WO.translation.z += 2e-4 * tick;
      }
      bus::Observation seen;
      seen.topic = bus::kPhysicsStateTopic;
      seen.type = bus::MessageType::kPhysicsState;
      seen.writer = "physics_node";
      seen.sequence = static_cast<std::uint64_t>(tick + 1);
      seen.received_ns = 5'000'000'000 + state.time_ns;
      const std::size_t size = codec.Encode(state, 0, 1000, bytes.data(), bytes.size());
      seen.payload.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_TRUE(recorder->Add(seen));
    }
    ASSERT_TRUE(recorder->Close(0, 0));
  }

  // A new one for each picture, which knows of none before.
  std::unique_ptr<Renderer> MakeRenderer() const {
    return std::move(*Renderer::Create(view::SceneMirror(scenario_).scene(),
                                       [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); }));
  }

  std::vector<picture::Image> Film() {
    std::vector<picture::Image> frames;
    const auto recording = view::RecordedScene::Open(options_.pictures.recording, scenario_);
    EXPECT_TRUE(recording) << recording.error().detail;
    const auto renderer = MakeRenderer();
    StructureShow structures(scenario_);
    const auto done =
        DrawFrames(options_, recording->get(), renderer.get(), &structures, [&](const picture::Image& frame) {
          frames.push_back(frame);
          return core::Result<void>();
        });
    EXPECT_TRUE(done) << done.error().detail;
    return frames;
  }

  picture::Image Still(double at_s) {
    Options options = options_;
    options.pictures.shot = folder_ / "still.png";
    options.pictures.at_s = at_s;
    const auto scene = SceneOf(options, scenario_);
    EXPECT_TRUE(scene) << scene.error().detail;
    const auto done = TakeShot(options, *scene, MakeRenderer().get());
    EXPECT_TRUE(done) << done.error().detail;
    return ReadPng(options.pictures.shot);
  }

  scene::Scenario scenario_;
  Options options_;
  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("replay_frames_" + std::to_string(getpid()));
};

TEST_F(ReplayFramesTest, AFrameIsTheStillOfItsTime) {
  const std::vector<picture::Image> frames = Film();
  ASSERT_EQ(frames.size(), 6U);
  for (const std::size_t k : {0U, 2U, 5U}) {
    EXPECT_EQ(frames[k].rgba, Still(0.1 * static_cast<double>(k)).rgba) << k;
    if (k > 0) {
      EXPECT_NE(frames[k].rgba, frames[0].rgba) << k;
    }
  }
}

TEST_F(ReplayFramesTest, TheSameRecordingGivesTheSameFrames) {
  const std::vector<picture::Image> first = Film(), second = Film();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) EXPECT_EQ(first[k].rgba, second[k].rgba) << k;
}

TEST_F(ReplayFramesTest, AFasterFilmHasTheFramesOfLaterTimes) {
  const std::vector<picture::Image> plain = Film();
  options_.pictures.speed = 2.0;
  options_.pictures.from_s = 0.1;
  const std::vector<picture::Image> fast = Film();
  ASSERT_EQ(fast.size(), 3U);
  EXPECT_EQ(fast[1].rgba, plain[3].rgba);
}

TEST_F(ReplayFramesTest, AnUnknownCameraIsRefusedWithTheNamesOfAll) {
  options_.view = "nowhere";
  const auto done = RenderFrames(options_, scenario_, [](const picture::Image&) { return core::Result<void>(); });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, core::ErrorCode::kInvalidInput);
  for (const scene::Camera& camera : scenario_.cameras) {
    EXPECT_NE(done.error().detail.find(camera.name), std::string::npos) << done.error().detail;
  }
}

}  // namespace
}  // namespace visual_node
