#include "nodes/visual_node/window/saved_views.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/write_file.hpp"
#include "scene/element_reader.hpp"

namespace visual_node {
namespace {

std::filesystem::path ViewsFolder() {
  if (const char* folder = std::getenv("VR_OOS_VIEWS"); folder != nullptr && *folder != '\0') return folder;
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0') {
    return std::filesystem::path(config) / "vr_oos" / "views";
  }
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home != nullptr ? home : ".") / ".config" / "vr_oos" / "views";
}

bool IsUsable(const scene::Camera& camera) {
  const glm::dvec3 along = camera.target_m - camera.eye_m;
  return std::isfinite(glm::length(along)) && glm::length(along) > 1e-6 && camera.vertical_fov_rad > 0.0 &&
         camera.vertical_fov_rad < 3.0;
}

}  // namespace

std::filesystem::path ViewsFile(const std::string& scenario) {
  return ViewsFolder() / (scenario + ".xml");
}

core::Result<void> WriteViews(const std::filesystem::path& file, const std::vector<scene::Camera>& views,
                              const view::Assets& assets) {
  std::string text = "<views>\n";
  for (const scene::Camera& view : views) text += view::CameraXml(view, assets) + "\n";
  return core::WriteFile(file, text + "</views>\n");
}

core::Result<std::vector<scene::Camera>> ReadViews(const std::filesystem::path& file, const view::Assets& assets) {
  std::vector<scene::Camera> views;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return views;
  const auto root = scene::ReadXml(file);
  if (!root) return core::Fail(core::ErrorCode::kDamaged, file.string() + ": " + root.error().front().what);
  for (const scene::XmlElement& element : root->children) {
    const scene::ElementReader read(element);
    scene::Camera camera;
    camera.name = element.Get("name");
    camera.eye_m = camera.target_m = glm::dvec3(std::nan(""));  // one without these is not usable
    read.Vector("eye_m", &camera.eye_m);
    read.Vector("target_m", &camera.target_m);
    read.Degrees("vertical_fov_deg", &camera.vertical_fov_rad);
    if (element.name != "camera" || !IsUsable(camera)) {
      return core::Fail(core::ErrorCode::kDamaged,
                        file.string() + ", line " + std::to_string(element.line) + ": this is no view");
    }
    camera.is_mounted = element.Find("mounted_on") != nullptr;
    const std::string object = element.Get("mounted_on", element.Get("follows"));
    const auto found = std::find(assets.instance_names.begin(), assets.instance_names.end(), object);
    if (found != assets.instance_names.end()) {
      camera.object = static_cast<int>(found - assets.instance_names.begin());
    } else if (!object.empty()) {
      return core::Fail(core::ErrorCode::kInvalidInput, file.string() + ", line " + std::to_string(element.line) +
                                                            ": there is no object '" + object + "' any more");
    }
    views.push_back(std::move(camera));
  }
  return views;
}

}  // namespace visual_node
