#include "view/scene.hpp"

namespace view {

int FindCamera(const Assets& assets, const std::string& name) {
  for (std::size_t i = 0; i < assets.cameras.size(); ++i) {
    if (assets.cameras[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

const scene::Camera& CameraFor(const Assets& assets, const std::string& fixed, const std::string& step) {
  int index = FindCamera(assets, fixed);
  if (index < 0) index = FindCamera(assets, step);
  return assets.cameras[index < 0 ? 0 : static_cast<std::size_t>(index)];
}

core::Result<void> CheckCamera(const Assets& assets, const std::string& name) {
  if (name.empty() || FindCamera(assets, name) >= 0) return {};
  std::string all;
  for (const scene::Camera& camera : assets.cameras) all += (all.empty() ? "" : ", ") + camera.name;
  return core::Fail(core::ErrorCode::kInvalidInput, "the scenario has no camera '" + name + "'; it has " + all);
}

}  // namespace view
