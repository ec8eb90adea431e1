#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {
namespace {

// CPU time of one live picture of module_replacement, of all threads. The arguments: camera, width. A second picture of
// the same scene, so the shadow map and the stars are those of the first; `moving` turns the camera and moves an
// object.
void BM_Draw(benchmark::State& state, bool is_moving) {
  setenv("LP_NUM_THREADS", "1", 0);
  const auto scenario =
      scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "module_replacement");
  static const auto context = GlContext::Create({.width = 64, .height = 64, .title = "bench", .is_visible = false});
  if (!scenario || !context) return state.SkipWithError("no scenario or no display");
  const view::SceneMirror mirror(*scenario);
  view::Scene scene = mirror.scene();
  auto renderer = Renderer::Create(scene, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
  if (!renderer) return state.SkipWithError(renderer.error().detail.c_str());
  for (std::size_t i = 0; i < scene.assets->meshes.size(); ++i) {
    auto mesh = vps::LoadVisualMesh(scene.assets->meshes[i]);
    if (!mesh) continue;  // an invisible object
    const std::vector<Piece> pieces = MakePieces(&*mesh);
    (*renderer)->SetDetail(i, *mesh, pieces);
  }
  const Look live{.with_penumbra = false, .detail_px = 0.25};
  scene::Camera camera = scene.assets->cameras.at(static_cast<std::size_t>(state.range(0)));
  const int width = static_cast<int>(state.range(1));
  const RenderTarget target(width, width * 9 / 16);
  if (!(*renderer)->Draw(scene, camera, target, live)) return state.SkipWithError("cannot draw");
  glFinish();
  for (auto _ : state) {
    if (is_moving) {
      camera.eye_m.x += 1e-4;
      for (view::Instance& instance : scene.instances) instance.X_WM.translation.z += instance.is_movable ? 2e-4 : 0.0;
    }
    benchmark::DoNotOptimize((*renderer)->Draw(scene, camera, target, live));
    glFinish();
  }
  state.SetLabel(camera.name);
}
BENCHMARK_CAPTURE(BM_Draw, still, false)
    ->ArgsProduct({{0, 1, 2, 3}, {640}})
    ->Args({0, 1280})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Draw, moving, true)
    ->ArgsProduct({{0, 1}, {448, 640}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

// Of it the picture from the light. The arguments: width, and that of the film in percent; by the processor or shaders.
void BM_Develop(benchmark::State& state, bool by_processor) {
  static const auto context = GlContext::Create({.width = 64, .height = 64, .title = "bench", .is_visible = false});
  auto film = Film::Create(by_processor);
  if (!film || !context) return state.SkipWithError("no display");
  const int width = static_cast<int>(state.range(0)), height = width * 9 / 16;
  const RenderTarget target(width, height);
  const int share = static_cast<int>(state.range(1));
  film->Begin(width * share / 100, height * share / 100);
  for (int y = 0; y < height; y += 20) {
    const float light[4] = {0.3f, static_cast<float>(y) / static_cast<float>(height), 0.1f, 1.0f};
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, y, width, 20);
    glClearBufferfv(GL_COLOR, 0, light);
    glDisable(GL_SCISSOR_TEST);
  }
  for (auto _ : state) {
    film->Develop(1.0f, target);
    glFinish();
  }
}
BENCHMARK_CAPTURE(BM_Develop, processor, true)
    ->ArgsProduct({{640, 1280}, {70, 100}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Develop, shaders, false)
    ->ArgsProduct({{640, 1280}, {70, 100}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace visual_node
