// How long a picture takes, on one core.

#include <benchmark/benchmark.h>

#include <cstdlib>

#include "raytrace/tracer.hpp"
#include "scene/load_scenario.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/scene_mirror.hpp"

namespace raytrace {
namespace {

// 1280x720. Argument: tiles::Mirrors.
void Draw(benchmark::State& state, const char* camera) {
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/module_replacement");
  if (!scenario) std::abort();
  const view::SceneMirror mirror(*scenario);
  const view::Scene& scene = mirror.scene();
  const auto tracer =
      Tracer::Create(scene, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
  if (!tracer) std::abort();
  (*tracer)->Update(scene, view::LightOf(scene.space));
  const int index = view::FindCamera(*scene.assets, camera);
  if (index < 0) std::abort();
  const Eye eye = Eye::Of(view::PlaceCamera(scene.assets->cameras[static_cast<std::size_t>(index)], scene), 1280, 720);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        (*tracer)->Draw(eye, {0, 0, eye.width, eye.height}, {static_cast<tiles::Mirrors>(state.range(0)), 0}));
  }
}
BENCHMARK_CAPTURE(Draw, overview, "overview")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Draw, cavity, "cavity")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace raytrace
