#include "view/scene.hpp"

#include <cstdio>

#include "view/projection.hpp"

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

scene::Camera PlaceCamera(const scene::Camera& camera, const Scene& scene) {
  if (camera.object < 0 || camera.object >= static_cast<int>(scene.instances.size())) return camera;
  core::Pose X_WO = scene.instances[static_cast<std::size_t>(camera.object)].X_WM;
  if (!camera.is_mounted) X_WO.rotation = {1.0, 0.0, 0.0, 0.0};
  scene::Camera placed = camera;
  placed.object = -1;
  placed.is_mounted = false;
  placed.eye_m = X_WO * camera.eye_m;
  placed.target_m = X_WO * camera.target_m;
  const bool has_up = camera.up != glm::dvec3(0.0);
  placed.up = X_WO.rotate(has_up ? camera.up : UpFor(camera.target_m - camera.eye_m));
  return placed;
}

scene::Camera Follow(const scene::Camera& placed, int object, const Scene& scene) {
  scene::Camera camera = placed;
  if (object < 0 || object >= static_cast<int>(scene.instances.size())) return camera;
  const glm::dvec3& p_WO = scene.instances[static_cast<std::size_t>(object)].X_WM.translation;
  camera.object = object;
  camera.is_mounted = false;
  camera.eye_m -= p_WO;
  camera.target_m -= p_WO;
  return camera;
}

std::string CameraXml(const scene::Camera& camera, const Assets& assets) {
  char numbers[200];
  std::snprintf(numbers, sizeof numbers,
                " eye_m=\"%.4f %.4f %.4f\" target_m=\"%.4f %.4f %.4f\" vertical_fov_deg=\"%.4g\"", camera.eye_m.x,
                camera.eye_m.y, camera.eye_m.z, camera.target_m.x, camera.target_m.y, camera.target_m.z,
                glm::degrees(camera.vertical_fov_rad));
  std::string line = "<camera name=\"" + camera.name + "\"" + numbers;
  if (camera.object >= 0) {
    line += std::string(camera.is_mounted ? " mounted_on" : " follows") + "=\"" +
            assets.instance_names[static_cast<std::size_t>(camera.object)] + "\"";
  }
  return line + "/>";
}

core::Result<void> CheckCamera(const Assets& assets, const std::string& name) {
  if (name.empty() || FindCamera(assets, name) >= 0) return {};
  std::string all;
  for (const scene::Camera& camera : assets.cameras) all += (all.empty() ? "" : ", ") + camera.name;
  return core::Fail(core::ErrorCode::kInvalidInput, "the scenario has no camera '" + name + "'; it has " + all);
}

void MoveSkins(Scene* scene) {
  constexpr double kSame = 1e-6;  // m and half a radian: rounding, and less than any picture shows
  for (const Skin& skin : scene->assets->skins) {
    Instance& instance = scene->instances[skin.instance];
    instance.X_WM = scene->instances[skin.goes_with.front()].X_WM * skin.X_JM;
    const core::Pose X_MW = instance.X_WM.inverse();
    std::vector<core::Pose> X_MJ;
    bool has_moved = instance.posture == nullptr;
    for (std::size_t k = 0; k < skin.goes_with.size(); ++k) {
      X_MJ.push_back(X_MW * scene->instances[skin.goes_with[k]].X_WM);
      if (has_moved) continue;
      const core::Pose& last = (*instance.posture)[k];
      const glm::dquat turn = X_MJ[k].rotation * glm::conjugate(last.rotation);
      has_moved = glm::distance(X_MJ[k].translation, last.translation) > kSame ||
                  glm::length(glm::dvec3(turn.x, turn.y, turn.z)) > kSame;
    }
    if (has_moved) instance.posture = std::make_shared<const std::vector<core::Pose>>(std::move(X_MJ));
  }
}

}  // namespace view
