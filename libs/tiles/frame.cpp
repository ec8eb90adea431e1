#include "tiles/frame.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/hash.hpp"

namespace tiles {
namespace {

constexpr std::uint8_t kVisible = 1, kMaterialGiven = 2, kFoil = 4;

core::RayInstance EncodeInstance(const view::Instance& instance) {
  const view::Material& material = instance.material;
  core::RayInstance encoded;
  encoded.flags =
      static_cast<std::uint8_t>((instance.is_visible ? kVisible : 0) |
                                (instance.is_material_given ? kMaterialGiven : 0) | (material.is_foil ? kFoil : 0));
  encoded.X_WM = instance.X_WM;
  encoded.opacity = instance.opacity;
  encoded.base_color = material.base_color;
  encoded.metallic = material.metallic;
  encoded.roughness = material.roughness;
  encoded.emissive = material.emissive;
  return encoded;
}

void Apply(const core::RayInstance& encoded, view::Instance* instance) {
  instance->is_visible = (encoded.flags & kVisible) != 0;
  instance->is_material_given = (encoded.flags & kMaterialGiven) != 0;
  instance->X_WM = encoded.X_WM;
  instance->opacity = encoded.opacity;
  view::Material& material = instance->material;
  material.base_color = encoded.base_color;
  material.metallic = encoded.metallic;
  material.roughness = encoded.roughness;
  material.emissive = encoded.emissive;
  material.is_foil = (encoded.flags & kFoil) != 0;
}

core::RayEye EncodeEye(const SeenPart& part) {
  core::RayEye encoded;
  encoded.x_px = static_cast<std::uint32_t>(part.at.x);
  encoded.y_px = static_cast<std::uint32_t>(part.at.y);
  encoded.width_px = static_cast<std::uint32_t>(part.at.width);
  encoded.height_px = static_cast<std::uint32_t>(part.at.height);
  encoded.X_WE = {glm::normalize(glm::quat_cast(part.eye.R_WE)), part.eye.eye_W};
  encoded.left = static_cast<float>(part.eye.left);
  encoded.right = static_cast<float>(part.eye.right);
  encoded.bottom = static_cast<float>(part.eye.bottom);
  encoded.top = static_cast<float>(part.eye.top);
  return encoded;
}

bool IsPartOf(const core::RayFrame& frame, const core::RayEye& eye) {
  const auto fits = [](std::uint64_t begin, std::uint64_t size, std::uint64_t all) {
    return size > 0 && begin + size <= all;
  };
  return fits(eye.x_px, eye.width_px, frame.width) && fits(eye.y_px, eye.height_px, frame.height) &&
         std::isfinite(eye.right - eye.left) && std::isfinite(eye.top - eye.bottom) && eye.left < eye.right &&
         eye.bottom < eye.top;
}

}  // namespace

std::vector<Tile> StackParts(const std::vector<glm::ivec2>& sizes_px) {
  std::vector<Tile> parts;
  int y = 0;
  for (const glm::ivec2& size_px : sizes_px) {
    parts.push_back({0, y, size_px.x, size_px.y});
    y += size_px.y;
  }
  return parts;
}

core::RayFrame EncodeFrame(const view::Scene& scene, const view::EnvironmentLight& light, const scene::Camera& placed,
                           int width, int height) {
  const double aspect = static_cast<double>(width) / height;
  return EncodeFrame(scene, light, {{view::FrustumOf(placed, aspect), {0, 0, width, height}}});
}

core::RayFrame EncodeFrame(const view::Scene& scene, const view::EnvironmentLight& light,
                           const std::vector<SeenPart>& parts) {
  core::RayFrame frame;
  for (const SeenPart& part : parts) {
    frame.width = std::max(frame.width, static_cast<std::uint32_t>(part.at.x + part.at.width));
    frame.height = std::max(frame.height, static_cast<std::uint32_t>(part.at.y + part.at.height));
    frame.eyes.push_back(EncodeEye(part));
  }
  frame.sun_direction_W = light.sun_direction_W;
  frame.sun = light.sun;
  frame.earth_direction_W = light.earth_direction_W;
  frame.earth_sine = light.earth_sine;
  frame.earth = light.earth;
  frame.panels = light.panels;
  frame.everywhere = light.everywhere;
  for (const view::Instance& instance : scene.instances) frame.instances.push_back(EncodeInstance(instance));
  for (const view::Sheet& sheet : scene.sheets) {
    // Of the nodes themselves: a count could be the same in another life of the viewer.
    const std::uint64_t version = core::Hash64(sheet.p_W.data(), sheet.p_W.size() * sizeof(glm::vec3));
    frame.sheets.push_back({static_cast<std::uint32_t>(sheet.p_W.size()), version, sheet.is_visible});
    frame.nodes_W.insert(frame.nodes_W.end(), sheet.p_W.begin(), sheet.p_W.end());
  }
  for (const view::Lamp& lamp : scene.lamps) frame.lamps.push_back({lamp.instance, lamp.color});
  return frame;
}

bool ApplyFrame(const core::RayFrame& frame, view::Scene* scene) {
  bool is_same =
      frame.instances.size() == scene->instances.size() && frame.sheets.size() == scene->sheets.size() &&
      frame.width > 0 && frame.height > 0 &&
      std::all_of(frame.eyes.begin(), frame.eyes.end(), [&](const core::RayEye& eye) { return IsPartOf(frame, eye); });
  std::size_t num_nodes = 0;
  for (std::size_t i = 0; is_same && i < frame.sheets.size(); ++i) {
    is_same = frame.sheets[i].num_nodes == scene->sheets[i].p_W.size();
    num_nodes += frame.sheets[i].num_nodes;
  }
  is_same = is_same && num_nodes == frame.nodes_W.size() &&
            std::all_of(frame.lamps.begin(), frame.lamps.end(),
                        [&](const core::RayLamp& lamp) { return lamp.instance < scene->instances.size(); });
  if (!is_same) return false;
  for (std::size_t i = 0; i < frame.instances.size(); ++i) Apply(frame.instances[i], &scene->instances[i]);
  auto node = frame.nodes_W.begin();
  for (std::size_t i = 0; i < frame.sheets.size(); ++i) {
    view::Sheet& sheet = scene->sheets[i];
    const auto end = node + frame.sheets[i].num_nodes;
    if (sheet.version != frame.sheets[i].version) std::copy(node, end, sheet.p_W.begin());
    node = end;
    sheet.version = frame.sheets[i].version;
    sheet.is_visible = frame.sheets[i].is_visible;
  }
  scene->lamps.clear();
  for (const core::RayLamp& lamp : frame.lamps) scene->lamps.push_back({lamp.instance, lamp.color});
  view::MoveSkins(scene);
  return true;
}

view::EnvironmentLight LightOf(const core::RayFrame& frame) {
  view::EnvironmentLight light;
  light.sun_direction_W = frame.sun_direction_W;
  light.sun = frame.sun;
  light.earth_direction_W = frame.earth_direction_W;
  light.earth_sine = frame.earth_sine;
  light.earth = frame.earth;
  light.panels = frame.panels;
  light.everywhere = frame.everywhere;
  return light;
}

Quality QualityOf(const core::RayFrame& frame) {
  const auto most = static_cast<std::uint8_t>(Mirrors::kAll);
  return {static_cast<Mirrors>(std::min(frame.mirrors, most)), frame.sample};
}

std::vector<SeenPart> PartsOf(const core::RayFrame& frame) {
  std::vector<SeenPart> parts;
  for (const core::RayEye& eye : frame.eyes) {
    view::Frustum frustum;
    frustum.eye_W = eye.X_WE.translation;
    frustum.R_WE = glm::mat3_cast(eye.X_WE.rotation);
    frustum.left = eye.left;
    frustum.right = eye.right;
    frustum.bottom = eye.bottom;
    frustum.top = eye.top;
    parts.push_back({frustum,
                     {static_cast<int>(eye.x_px), static_cast<int>(eye.y_px), static_cast<int>(eye.width_px),
                      static_cast<int>(eye.height_px)}});
  }
  return parts;
}

std::uint64_t FrameDigest(const core::RayFrame& frame) {
  std::uint64_t hash = 0;
  const auto add = [&hash](const auto&... values) { ((hash = core::Hash64(&values, sizeof values, hash)), ...); };
  const auto add_pose = [&add](const core::Pose& X) {
    add(X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z, X.translation);
  };
  add(frame.width, frame.height, frame.mirrors, frame.sun_direction_W, frame.sun, frame.earth_direction_W,
      frame.earth_sine, frame.earth, frame.panels, frame.everywhere);
  for (const core::RayEye& eye : frame.eyes) {
    add(eye.x_px, eye.y_px, eye.width_px, eye.height_px, eye.left, eye.right, eye.bottom, eye.top);
    add_pose(eye.X_WE);
  }
  for (const core::RayInstance& instance : frame.instances) {
    add_pose(instance.X_WM);
    add(instance.flags, instance.opacity, instance.base_color, instance.metallic, instance.roughness,
        instance.emissive);
  }
  for (const core::RaySheet& sheet : frame.sheets) add(sheet.version, sheet.is_visible);
  for (const core::RayLamp& lamp : frame.lamps) add(lamp.instance, lamp.color);
  return hash;
}

}  // namespace tiles
