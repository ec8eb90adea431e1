#include "nodes/visual_node/pictures/still.hpp"

#include <cstdio>

#include "nodes/visual_node/pictures/offline.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {

core::Result<Image> RenderSmooth(Renderer& renderer, const view::Scene& scene, const scene::Camera& camera, int width,
                                 int height) {
  const RenderTarget target(kSmoothSamples * width, kSmoothSamples * height);
  if (auto drawn = renderer.Draw(scene, camera, target); !drawn) return tl::unexpected(drawn.error());
  return Shrink(target.Read(), kSmoothSamples);
}

core::Result<void> RenderStills(const Options& options, const scene::Scenario& scenario) {
  const view::SceneMirror mirror(scenario);
  const auto offline = Offline::Create(scenario, options.view);
  if (!offline) return tl::unexpected(offline.error());
  for (const scene::Camera& camera : mirror.scene().assets->cameras) {
    if (!options.view.empty() && camera.name != options.view) continue;
    const auto image = RenderSmooth(*offline->renderer, mirror.scene(), camera, options.width, options.height);
    if (!image) return tl::unexpected(image.error());
    const std::filesystem::path file = options.out / (camera.name + ".png");
    if (auto written = WritePng(*image, file); !written) return written;
    std::printf("%s\n", file.c_str());
  }
  return {};
}

}  // namespace visual_node
