#include "nodes/headset_node/headset_node.hpp"

#include <cstdio>
#include <filesystem>

#include "core/clock.hpp"
#include "nodes/headset_node/eye_frustum.hpp"
#include "nodes/headset_node/headset.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "nodes/visual_node/receiver.hpp"
#include "nodes/visual_node/sky/earth_air.hpp"
#include "view/room.hpp"

namespace headset_node {
namespace {

// Labels stand where what they name is; lines in a picture's corners cannot be read in a headset.
core::Result<void> DrawEye(const view::Scene& scene, const view::Frustum& eye, visual_node::Renderer* renderer,
                           const visual_node::RenderTarget& target) {
  const visual_node::Look look{.with_texts = false, .with_penumbra = false};
  if (auto drawn = renderer->Draw(scene, eye, target, look); !drawn) return drawn;
  const std::vector<view::TextLine> no_lines;
  const std::vector<view::Graph> no_graphs;
  const visual_node::Hud labels{no_lines, visual_node::HudOf(scene, eye, target.width(), target.height()).labels,
                                no_graphs};
  return renderer->DrawTexts(labels, target.width(), target.height());
}

}  // namespace

core::Result<void> RunHeadset(const Options& options, const scene::Scenario& scenario,
                              const volatile std::sig_atomic_t& is_stop_wanted) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);  // else the first file that is written complains
  visual_node::LatencyLog log;
  if (auto opened = log.Open(options.out / "latency_visual.csv"); !opened) return opened;
  visual_node::Receiver receiver(scenario, &log);
  if (auto started = receiver.Start(options.node); !started) return started;
  receiver.Update();
  view::Scene shown = receiver.scene();
  if (auto known = view::CheckCamera(*shown.assets, options.view); !known) return known;
  const auto chosen = view::ReadChoices(options.show, shown.assets->instance_names);
  if (!chosen) return tl::unexpected(chosen.error());
  receiver.Choose([&](view::Choices& choices) { choices = *chosen; });
  const auto context = visual_node::GlContext::Create({.title = scenario.title, .is_visible = false});
  if (!context) return tl::unexpected(context.error());
  const auto headset = Headset::Open((*context)->window());
  if (!headset) return tl::unexpected(headset.error());
  const auto renderer =
      visual_node::Renderer::Create(shown, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
  if (!renderer) return tl::unexpected(renderer.error());
  if (const auto air = visual_node::CachedAir()) (*renderer)->SetAir(*air);
  const glm::ivec2 size_px = (*headset)->size_px();
  std::printf("%s, %d x %d pixels for each eye\n", (*headset)->description().c_str(), size_px.x, size_px.y);
  std::fflush(stdout);
  const visual_node::RenderTarget target(size_px.x, size_px.y);
  std::uint64_t frames = 0;
  while (is_stop_wanted == 0 && !(*headset)->is_over()) {
    const auto is_wanted = (*headset)->BeginFrame();
    if (!is_wanted) return tl::unexpected(is_wanted.error());
    if (!*is_wanted) continue;
    const std::int64_t start_ns = core::MonotonicNow_ns();
    const bool is_new = receiver.Update();
    if (is_new) shown = receiver.scene();
    const scene::Camera& camera = view::CameraFor(*shown.assets, options.view, shown.step);
    const core::Pose X_WR = view::RoomOf(view::PlaceCamera(camera, shown));
    for (std::size_t eye = 0; eye < kNumEyes; ++eye) {
      const view::Frustum frustum = FrustumOf(X_WR, (*headset)->eyes()[eye]);
      if (auto drawn = DrawEye(shown, frustum, renderer->get(), target); !drawn) return drawn;
      if (auto taken = (*headset)->Show(eye, target); !taken) return taken;
    }
    if (auto ended = (*headset)->EndFrame(); !ended) return ended;
    if (is_new) {
      core::Trace trace = shown.through_physics;
      trace.Add(core::Stage::kFrameStart, start_ns);
      trace.Add(core::Stage::kFrameDone, core::MonotonicNow_ns());
      log.AddFrame(trace);
    }
    log.Drain();
    receiver.SetFrames(++frames);
    receiver.SetReady();
  }
  receiver.Stop();
  log.Drain();
  log.Close();
  std::printf("%llu frames\n", static_cast<unsigned long long>(frames));
  return {};
}

}  // namespace headset_node
