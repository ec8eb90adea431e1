#include "nodes/visual_node/pictures/shot.hpp"

#include <cstdio>

#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/composition.hpp"
#include "nodes/visual_node/draw/object_pass.hpp"
#include "nodes/visual_node/pictures/offline.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/structures.hpp"
#include "view/recorded_scene.hpp"

namespace visual_node {
namespace {

core::Result<void> WriteObjects(const ObjectPicture& objects, const view::Assets& assets,
                                const PictureOptions& options) {
  if (!options.ids.empty()) {
    if (auto written = WritePng(objects.ids, options.ids); !written) return written;
    std::filesystem::path names = options.ids;
    if (auto written = WriteIdNames(assets, names.replace_extension(".json")); !written) return written;
    std::printf("%s\n%s\n", options.ids.c_str(), names.c_str());
  }
  if (options.depth.empty()) return {};
  const bool is_in_metres = options.depth.extension() == ".pfm";
  auto written =
      is_in_metres ? WritePfm(objects.depth_m, options.depth) : WritePng(ToMillimetres(objects.depth_m), options.depth);
  if (written) std::printf("%s\n", options.depth.c_str());
  return written;
}

// The light of the newest picture, at the picture's size.
picture::Measured<float> LightOf(const Film& film, int width, int height) {
  const std::vector<float> light = film.ReadLight();
  const int samples = film.width() / width;
  const float share = 1.0f / static_cast<float>(samples * samples);
  const auto index = [](int x, int y, int row_length) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(row_length) + static_cast<std::size_t>(x);
  };
  picture::Measured<float> mean(width, height, 3);
  for (int y = 0; y < film.height(); ++y) {  // from the bottom
    for (int x = 0; x < film.width(); ++x) {
      const std::size_t from = index(x, y, film.width());
      const std::size_t to = index(x / samples, height - 1 - y / samples, width);
      for (std::size_t k = 0; k < 3; ++k) mean.values[3 * to + k] += share * light[4 * from + k];
    }
  }
  return mean;
}

}  // namespace

core::Result<view::Scene> SceneOf(const Options& all, const scene::Scenario& scenario) {
  const PictureOptions& options = all.pictures;
  view::SceneMirror mirror(scenario);
  const auto choices = view::ReadChoices(all.show, mirror.scene().assets->instance_names);
  if (!choices) return tl::unexpected(choices.error());
  const auto with_structures = [&](view::Scene shown) {
    StructureShow(scenario).BuildAndAddTo(*choices, &shown);
    return shown;
  };
  if (options.recording.empty()) {
    mirror.Choose(*choices);
    mirror.Refresh(0);
    return with_structures(mirror.scene());
  }
  auto recorded = view::RecordedScene::Open(options.recording, scenario);
  if (!recorded) return tl::unexpected(recorded.error());
  (*recorded)->Choose(*choices);
  if (auto inside = (*recorded)->CheckTime(options.at_s); !inside) return tl::unexpected(inside.error());
  if (auto there = (*recorded)->GoTo(options.at_s.value_or((*recorded)->duration_s())); !there) {
    return tl::unexpected(there.error());
  }
  return with_structures((*recorded)->scene());
}

core::Result<void> TakeShot(const Options& options, const view::Scene& scene, Renderer* renderer) {
  const auto composition = CompositionOf(options, *scene.assets);
  if (!composition) return tl::unexpected(composition.error());
  const scene::Camera& camera = view::CameraFor(*scene.assets, composition->layout.steered(), scene.step);
  auto composer = Composer::Create();
  if (!composer) return tl::unexpected(composer.error());
  const auto choices = view::ReadChoices(options.show, scene.assets->instance_names);
  if (!choices) return tl::unexpected(choices.error());
  picture::Measured<float> light;
  const auto image = RenderSmooth(*renderer, *composer, {scene, camera, *composition}, options.width, options.height,
                                  {.add = [&](const RenderTarget& target) {
                                    if (!options.pictures.hdr.empty()) {
                                      light = LightOf(renderer->film(), options.width, options.height);
                                    }
                                    return AddInset(*renderer, scene, *choices, composition->viewing.stereo, target);
                                  }});
  if (!image) return tl::unexpected(image.error());
  if (const std::filesystem::path& file = options.pictures.shot; !file.empty()) {
    if (auto written = WritePng(*image, file); !written) return written;
    std::printf("%s\n", file.c_str());
  }
  if (const std::filesystem::path& file = options.pictures.hdr; !file.empty()) {
    if (auto written = WritePfm(light, file); !written) return written;
    std::printf("%s\n", file.c_str());
  }
  if (options.pictures.ids.empty() && options.pictures.depth.empty()) return {};
  const auto pass = ObjectPass::Create();
  if (!pass) return tl::unexpected(pass.error());
  return WriteObjects(pass->Draw(*renderer, scene, camera, options.width, options.height), *scene.assets,
                      options.pictures);
}

core::Result<void> RenderShot(const Options& options, const scene::Scenario& scenario) {
  const auto scene = SceneOf(options, scenario);
  if (!scene) return tl::unexpected(scene.error());
  const auto offline = Offline::Create(scenario, options.view);
  if (!offline) return tl::unexpected(offline.error());
  return TakeShot(options, *scene, offline->renderer.get());
}

}  // namespace visual_node
