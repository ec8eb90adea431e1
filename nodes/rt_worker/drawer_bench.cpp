// How long the pictures of a run take, on one core. With OOS_WRITE_COSTS=FILE and OOS_RECORDING=scene.mcap of a run of
// module_replacement it writes what libs/tiles/schedule_test.cpp reads: the cost of each square of 32 pixels.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "nodes/rt_worker/drawer.hpp"
#include "scene/load_scenario.hpp"
#include "tiles/frame.hpp"
#include "view/recorded_scene.hpp"

namespace rt_worker {
namespace {

constexpr int kWidth = 1280, kHeight = 720, kSquare = 32, kFrames = 24;

struct Run {
  scene::Scenario scenario;
  std::unique_ptr<view::RecordedScene> recorded;
  std::optional<Drawer> drawer;

  // The picture at a share of the recording, as the viewer shows it.
  core::RayFrame FrameAt(double share) {
    if (!recorded->GoTo(share * recorded->duration_s())) std::abort();
    const view::Scene& scene = recorded->scene();
    const scene::Camera camera = view::PlaceCamera(view::CameraFor(*scene.assets, "", scene.step), scene);
    core::RayFrame frame = tiles::EncodeFrame(scene, view::LightOf(scene.space), camera, kWidth, kHeight);
    static std::uint64_t number = 0;
    frame.frame = ++number;
    frame.mirrors = static_cast<std::uint8_t>(tiles::Mirrors::kHalf);
    return frame;
  }
  double Cost_us(const core::RayFrame& frame, std::uint32_t x, std::uint32_t y, std::uint32_t width,
                 std::uint32_t height) {
    core::RayTile tile;
    if (!drawer->Draw(frame, {1, frame.frame, x, y, width, height}, &tile)) std::abort();
    benchmark::DoNotOptimize(tile.pixels);
    return 1e-3 * static_cast<double>(tile.cost_ns);
  }
};

std::unique_ptr<Run> OpenRun() {
  const char* const recording = std::getenv("OOS_RECORDING");
  if (recording == nullptr) return nullptr;
  auto run = std::make_unique<Run>();
  auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
  if (!scenario) std::abort();
  run->scenario = std::move(*scenario);
  auto recorded = view::RecordedScene::Open(recording, run->scenario);
  if (!recorded) std::abort();
  run->recorded = std::move(*recorded);
  auto drawer = Drawer::Create(run->recorded->scene(),
                               [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
  if (!drawer) std::abort();
  run->drawer.emplace(std::move(*drawer));
  return run;
}

void WriteCosts(Run* run, const char* file) {
  std::ofstream out(file);
  out << kWidth << ' ' << kHeight << '\n';
  for (int i = 0; i < kFrames; ++i) {
    const core::RayFrame frame = run->FrameAt((i + 0.5) / kFrames);
    run->Cost_us(frame, 0, 0, 8, 8);  // moves things, which is no square's cost
    for (std::uint32_t y = 0; y < kHeight; y += kSquare) {
      for (std::uint32_t x = 0; x < kWidth; x += kSquare) {
        out << std::lround(run->Cost_us(frame, x, y, kSquare, std::min<std::uint32_t>(kSquare, kHeight - y))) << ' ';
      }
    }
    out << '\n';
  }
}

void PicturesOfARun(benchmark::State& state) {
  const std::unique_ptr<Run> run = OpenRun();
  if (run == nullptr) {
    state.SkipWithError("OOS_RECORDING names no recording");
    return;
  }
  if (const char* const file = std::getenv("OOS_WRITE_COSTS")) WriteCosts(run.get(), file);
  double share = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    share = share + 0.05 < 1.0 ? share + 0.05 : 0.0;
    const core::RayFrame frame = run->FrameAt(share);
    state.ResumeTiming();
    for (std::uint32_t y = 0; y < kHeight; y += 72) {
      for (std::uint32_t x = 0; x < kWidth; x += 128) run->Cost_us(frame, x, y, 128, 72);
    }
  }
}
BENCHMARK(PicturesOfARun)->Unit(benchmark::kMillisecond)->Iterations(20);

}  // namespace
}  // namespace rt_worker
