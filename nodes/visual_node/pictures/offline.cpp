#include "nodes/visual_node/pictures/offline.hpp"

#include <cstdio>

#include "nodes/visual_node/sky/earth_air.hpp"
#include "view/scene_mirror.hpp"

namespace visual_node {

core::Result<Offline> Offline::Create(const scene::Scenario& scenario, const std::string& camera) {
  const view::SceneMirror mirror(scenario);
  const view::Scene& scene = mirror.scene();
  if (auto known = view::CheckCamera(*scene.assets, camera); !known) return tl::unexpected(known.error());
  auto context = GlContext::Create({.width = 64, .height = 64, .title = "VR-OOS", .is_visible = false});
  if (!context) return tl::unexpected(context.error());
  auto renderer = Renderer::Create(scene, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
  if (!renderer) return tl::unexpected(renderer.error());
  if (const auto air = CachedAir()) {
    (*renderer)->SetAir(*air);
  } else {
    std::fprintf(stderr, "%s\n", air.error().detail.c_str());
  }
  return Offline{std::move(*context), std::move(*renderer)};
}

}  // namespace visual_node
