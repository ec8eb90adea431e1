#include "nodes/visual_node/pictures/replay_frames.hpp"

#include <cmath>
#include <cstdio>

#include "core/clock.hpp"
#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/composition.hpp"
#include "nodes/visual_node/pictures/offline.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "view/recorded_scene.hpp"

namespace visual_node {
namespace {

constexpr std::int64_t kProgressPeriod_ns = 5 * core::kNanosecondsPerSecond;

}  // namespace

core::Result<void> DrawFrames(const Options& options, view::RecordedScene* recording, Renderer* renderer,
                              StructureShow* structures, const FrameSink& sink) {
  const PictureOptions& wanted = options.pictures;
  for (const auto& time_s : {std::optional(wanted.from_s), wanted.to_s}) {
    if (auto inside = recording->CheckTime(time_s); !inside) return inside;
  }
  const auto composition = CompositionOf(options, *recording->scene().assets);
  if (!composition) return tl::unexpected(composition.error());
  auto composer = Composer::Create();
  if (!composer) return tl::unexpected(composer.error());
  const double length_s = (wanted.to_s.value_or(recording->duration_s()) - wanted.from_s) / wanted.speed;
  if (length_s < 0.0) return core::Fail(core::ErrorCode::kInvalidInput, "--to is before --from");
  // A length of three frames has three, though 3 / 30 s * 30 is a little less than 3.
  const auto count = static_cast<std::uint64_t>(std::floor(length_s * options.max_frames_per_s + 1e-6)) + 1;
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::int64_t next_progress_ns = begin_ns + kProgressPeriod_ns;
  for (std::uint64_t k = 0; k < count; ++k) {
    const double t_s = wanted.from_s + wanted.speed * static_cast<double>(k) / options.max_frames_per_s;
    if (auto there = recording->GoTo(t_s); !there) return there;
    view::Scene scene = recording->scene();
    structures->BuildAndAddTo(recording->choices(), &scene);
    const scene::Camera& camera = view::CameraFor(*scene.assets, composition->layout.steered(), scene.step);
    const auto add_inset = [&](const RenderTarget& target) {
      return AddInset(*renderer, scene, recording->choices(), composition->viewing.stereo, target);
    };
    const auto image = RenderSmooth(*renderer, *composer, {scene, camera, *composition}, options.width, options.height,
                                    {.add = add_inset});
    if (!image) return tl::unexpected(image.error());
    if (auto taken = sink(*image); !taken) return taken;
    if (const std::int64_t now_ns = core::MonotonicNow_ns(); now_ns >= next_progress_ns) {
      next_progress_ns = now_ns + kProgressPeriod_ns;
      const double left_s = 1e-9 * static_cast<double>(now_ns - begin_ns) / static_cast<double>(k + 1) *
                            static_cast<double>(count - k - 1);
      std::fprintf(stderr, "frame %llu of %llu, %.0f s left\n", static_cast<unsigned long long>(k + 1),
                   static_cast<unsigned long long>(count), left_s);
    }
  }
  return {};
}

core::Result<void> RenderFrames(const Options& options, const scene::Scenario& scenario, const FrameSink& sink) {
  const auto recording = view::RecordedScene::Open(options.pictures.recording, scenario);
  if (!recording) return tl::unexpected(recording.error());
  const auto choices = view::ReadChoices(options.show, (*recording)->scene().assets->instance_names);
  if (!choices) return tl::unexpected(choices.error());
  (*recording)->Choose(*choices);
  const auto offline = Offline::Create(scenario, options.view);
  if (!offline) return tl::unexpected(offline.error());
  StructureShow structures(scenario);
  return DrawFrames(options, recording->get(), offline->renderer.get(), &structures, sink);
}

core::Result<void> WritePpm(const picture::Image& image, std::FILE* file) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(image.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    rgb.insert(rgb.end(), {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]});
  }
  std::fprintf(file, "P6\n%d %d\n255\n", image.width, image.height);
  if (std::fwrite(rgb.data(), 1, rgb.size(), file) == rgb.size() && std::fflush(file) == 0) return {};
  return core::Fail(core::ErrorCode::kIo, "nobody reads the frames any more");
}

}  // namespace visual_node
