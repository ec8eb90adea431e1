// How many frames of 1280x720 a second worker processes on this machine trace, of a recorded run that is played at its
// own speed. Nothing is drawn over them: what a viewer adds on the same cores comes on top. OOS_RECORDING names a
// scene.mcap of module_replacement; the workers' program is ../../bin/rt_worker from here.

#include <benchmark/benchmark.h>

#include <cstdlib>

#include "bus/membership/registry.hpp"
#include "core/clock.hpp"
#include "nodes/rt_visual_node/exchange.hpp"
#include "scene/load_scenario.hpp"
#include "tiles/frame.hpp"
#include "tools/process/group.hpp"
#include "view/recorded_scene.hpp"

namespace rt_visual_node {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr std::uint64_t kSession = 12;
constexpr double kWarm_s = 2.0, kMeasured_s = 10.0, kFrom_s = 4.0;

process::Command WorkerOf(const scene::Scenario& scenario, const std::string& registry, std::size_t seat) {
  process::Command worker;
  worker.name = tiles::WorkerName("visual_node", seat);
  worker.program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "../../bin/rt_worker";
  worker.arguments = {"--name",     worker.name, "--scenario",     scenario.file.string(),
                      "--registry", registry,    "--session",      std::to_string(kSession),
                      "--out",      "/tmp",      "--no_encryption"};
  worker.log = "/dev/null";
  return worker;
}

// Arguments: workers, tiles::Mirrors.
void FramesOfARun(benchmark::State& state) {
  const char* const recording = std::getenv("OOS_RECORDING");
  if (recording == nullptr) {
    state.SkipWithError("OOS_RECORDING names no recording");
    return;
  }
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
  auto registry = bus::Registry::Create({.endpoint = "tcp://127.0.0.1:0", .session = kSession, .is_encrypted = false});
  if (!scenario || !registry) std::abort();
  const auto recorded = view::RecordedScene::Open(recording, *scenario);
  if (!recorded) std::abort();
  bus::NodeOptions options;
  options.name = "visual_node";
  options.registry = (*registry)->endpoint();
  options.session = kSession;
  options.is_encrypted = false;
  Exchange exchange(options);
  if (!exchange.Start()) std::abort();
  process::Group group;
  const auto workers = static_cast<std::size_t>(state.range(0));
  for (std::size_t seat = 1; seat <= workers; ++seat) {
    if (!group.Spawn(WorkerOf(*scenario, options.registry, seat))) std::abort();
  }
  std::uint64_t frames = 0;
  double cost_s = 0.0, seconds = 0.0;
  for (auto _ : state) {
    std::int64_t begin_ns = 0;
    double from_s = kFrom_s;
    for (;;) {
      const std::int64_t now_ns = core::MonotonicNow_ns();
      if (begin_ns == 0 && exchange.figures().workers == workers) begin_ns = now_ns;
      seconds = begin_ns == 0 ? 0.0 : 1e-9 * static_cast<double>(now_ns - begin_ns) - kWarm_s;
      if (seconds > kMeasured_s) break;
      if (!(*recorded)->GoTo(from_s + std::max(seconds + kWarm_s, 0.0))) std::abort();
      const view::Scene& scene = (*recorded)->scene();
      const scene::Camera camera = view::PlaceCamera(view::CameraFor(*scene.assets, "", scene.step), scene);
      Wish wish{.frame = tiles::EncodeFrame(scene, view::LightOf(scene.space), camera, kWidth, kHeight),
                .scene = scene,
                .camera = camera};
      wish.frame.mirrors = static_cast<std::uint8_t>(state.range(1));
      exchange.Want(std::move(wish));
      const auto drawn = exchange.Take(now_ns + 5'000'000);
      if (drawn == nullptr || seconds <= 0.0) continue;
      ++frames;
      cost_s += drawn->cost_s;
    }
  }
  state.counters["frames_per_s"] = static_cast<double>(frames) / seconds;
  state.counters["cores_ms"] = 1e3 * cost_s / static_cast<double>(std::max<std::uint64_t>(frames, 1));
}
BENCHMARK(FramesOfARun)
    ->Args({1, 1})
    ->Args({2, 1})
    ->Args({2, 2})
    ->Args({2, 0})
    ->Unit(benchmark::kSecond)
    ->Iterations(1);

}  // namespace
}  // namespace rt_visual_node
