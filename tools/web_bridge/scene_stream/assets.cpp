#include "tools/web_bridge/scene_stream/assets.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "nodes/visual_node/draw/overlay_shaders.hpp"
#include "nodes/visual_node/draw/surface_shaders.hpp"
#include "nodes/visual_node/film/exposure.hpp"
#include "nodes/visual_node/film/film_shaders.hpp"
#include "nodes/visual_node/gl/closed_mesh.hpp"
#include "nodes/visual_node/sky/fine_structure.hpp"
#include "nodes/visual_node/sky/ground.hpp"
#include "nodes/visual_node/sky/sky_shaders.hpp"
#include "space/orbit.hpp"
#include "space/stars/star_file.hpp"
#include "tools/web_bridge/scene_stream/numbers.hpp"
#include "view/appearance/environment_light.hpp"
#include "view/appearance/foil.hpp"
#include "view/appearance/material.hpp"
#include "view/appearance/sheet_mesh.hpp"
#include "view/appearance/split_sum.hpp"
#include "view/choices.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace scene_stream {
namespace {

constexpr std::pair<const char*, const char*> kShaders[] = {{"irradiance", visual_node::kIrradiance},
                                                            {"surface_vertex", visual_node::kSurfaceVertex},
                                                            {"surface_fragment", visual_node::kSurfaceFragment},
                                                            {"overlay_vertex", visual_node::kOverlayVertex},
                                                            {"overlay_fragment", visual_node::kOverlayFragment},
                                                            {"ring_vertex", visual_node::kRingVertex},
                                                            {"line_vertex", visual_node::kLineVertex},
                                                            {"flat_fragment", visual_node::kFlatFragment},
                                                            {"point_vertex", visual_node::kPointVertex},
                                                            {"point_fragment", visual_node::kPointFragment},
                                                            {"grain_vertex", visual_node::kGrainVertex},
                                                            {"cube_fragment", visual_node::kCubeFragment},
                                                            {"sphere_fragment", visual_node::kSphereFragment},
                                                            {"phantom_fragment", visual_node::kPhantomFragment},
                                                            {"mix_fragment", visual_node::kMixFragment},
                                                            {"film_vertex", visual_node::kFilmVertex},
                                                            {"tone_curve", visual_node::kToneCurve},
                                                            {"develop_fragment", visual_node::kDevelopFragment},
                                                            {"meter_fragment", visual_node::kMeterFragment},
                                                            {"smooth_fragment", visual_node::kSmoothFragment},
                                                            {"earth_vertex", visual_node::kEarthVertex},
                                                            {"earth_fragment", visual_node::kEarthFragment},
                                                            {"sky_vertex", visual_node::kSkyVertex},
                                                            {"stars_fragment", visual_node::kStarsFragment},
                                                            {"sun_fragment", visual_node::kSunFragment},
                                                            {"moon_fragment", visual_node::kMoonFragment},
                                                            {"earth_air_fragment", visual_node::kEarthAirFragment}};

template <class T>
void PutTable(int width, int height, int num_channels, std::span<const T> values, oos::SceneTable* table) {
  table->set_width(static_cast<std::uint32_t>(width));
  table->set_height(static_cast<std::uint32_t>(height));
  table->set_num_channels(static_cast<std::uint32_t>(num_channels));
  table->set_has_bytes(sizeof(T) == 1);
  Append(values, table->mutable_values());
}

// 0 means none.
std::uint32_t OneMore(int index) {
  return static_cast<std::uint32_t>(index + 1);
}

// Vertices without joints, as another part of a mesh with a skin may have, have no weights: they stay.
void PutSkin(const vps::VisualMesh& mesh, oos::SceneMesh* message) {
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
      const bool has_joints = i < primitive.joints.size();
      const glm::vec4 joints = has_joints ? glm::vec4(primitive.joints[i]) : glm::vec4(0.0f);
      const glm::vec4 weights = has_joints ? primitive.weights[i] : glm::vec4(0.0f);
      for (const glm::vec4& four : {joints, weights})
        Append(std::span<const float>(&four.x, 4), message->mutable_skin());
    }
  }
  for (const vps::VisualJoint& joint : mesh.joints) Append(joint.X_JMBind, message->mutable_joints());
}

// `variant`: of its looks; empty: the first.
oos::SceneMesh MeshMessage(const vps::VisualMesh& mesh, const std::string& variant) {
  oos::SceneMesh message;
  const bool has_skin = !mesh.joints.empty();
  const bool is_closed = !has_skin && visual_node::IsClosedAndFacesOutwards(mesh);
  if (has_skin) PutSkin(mesh, &message);
  std::uint32_t num_vertices = 0, num_indices = 0;
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    oos::ScenePart* part = message.add_parts();
    part->set_first_index(num_indices);
    part->set_num_indices(static_cast<std::uint32_t>(primitive.indices.size()));
    const vps::VisualMaterial& look = view::LookOf(primitive, mesh, variant);
    Put(view::MaterialOf(look), part->mutable_surface());
    part->set_is_lens(look.is_lens);
    part->set_is_two_sided(look.is_two_sided && !is_closed);
    part->set_base_texture(OneMore(look.base_texture));
    part->set_surface_texture(OneMore(look.surface_texture));
    part->set_normal_texture(OneMore(look.normal_texture));
    part->set_emissive_texture(OneMore(look.emissive_texture));
    part->set_has_occlusion(look.has_occlusion);
    for (std::size_t i = 0; i < primitive.positions.size(); ++i) {
      const glm::vec2 uv = primitive.uvs.empty() ? glm::vec2(0.0f) : primitive.uvs[i];
      Append(primitive.positions[i], message.mutable_vertices());
      Append(primitive.normals[i], message.mutable_vertices());
      Append(std::span<const float>(&uv.x, 2), message.mutable_vertices());
    }
    std::vector<std::uint32_t> indices = primitive.indices;
    for (std::uint32_t& index : indices) index += num_vertices;
    Append(std::span<const std::uint32_t>(indices), message.mutable_indices());
    num_vertices += static_cast<std::uint32_t>(primitive.positions.size());
    num_indices += static_cast<std::uint32_t>(indices.size());
  }
  for (const vps::VisualTexture& picture : mesh.textures) {
    oos::SceneTexture* texture = message.add_textures();
    texture->set_width(static_cast<std::uint32_t>(picture.width));
    texture->set_height(static_cast<std::uint32_t>(picture.height));
    texture->set_is_color(picture.is_color);
    Append(std::span<const std::uint8_t>(picture.rgba), texture->mutable_rgba());
  }
  return message;
}

// A variant of a mesh is a mesh of its own here.
core::Result<void> AddMeshes(const view::Scene& scene, oos::SceneAssets* assets) {
  for (const std::filesystem::path& path : scene.assets->meshes) {
    if (path.empty()) {  // an invisible object
      assets->add_meshes();
      continue;
    }
    const core::Result<vps::VisualMesh> mesh = vps::LoadVisualMesh(path);
    if (!mesh) return tl::unexpected(mesh.error());
    *assets->add_meshes() = MeshMessage(*mesh, "");
  }
  const auto& variants = scene.assets->variants;
  for (std::size_t i = 0; i < std::min(variants.size(), scene.instances.size()); ++i) {
    if (variants[i].empty()) continue;
    const auto mesh = vps::LoadVisualMesh(scene.assets->meshes[scene.instances[i].mesh]);
    if (!mesh) return tl::unexpected(mesh.error());
    assets->mutable_instances(static_cast<int>(i))->set_mesh(static_cast<std::uint32_t>(assets->meshes_size()));
    *assets->add_meshes() = MeshMessage(*mesh, variants[i]);
  }
  return {};
}

// How a sheet was before it moved: what is fixed in its material hangs on it.
void AddSheets(const view::Scene& scene, oos::SceneAssets* assets) {
  for (const view::Sheet& sheet : scene.sheets) {
    const vps::VisualPrimitive mesh = view::MakeSheetMesh(sheet);
    std::string* bytes = assets->add_sheets_at_rest();
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      Append(mesh.positions[i], bytes);
      Append(mesh.normals[i], bytes);
    }
  }
}

void AddNames(const scene::Scenario& scenario, const view::Scene& scene, oos::SceneAssets* assets) {
  assets->set_title(scenario.title);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    oos::SceneInstance* message = assets->add_instances();
    if (i < scene.assets->instance_names.size()) message->set_name(scene.assets->instance_names[i]);
    message->set_mesh(instance.mesh);
    message->set_is_movable(instance.is_movable);
    message->set_is_scenery(instance.is_scenery);
  }
  for (const scene::Camera& camera : scene.assets->cameras) {
    oos::SceneCamera* message = assets->add_cameras();
    message->set_name(camera.name);
    Put(camera.eye_m, message->mutable_eye_m());
    Put(camera.target_m, message->mutable_target_m());
    message->set_vertical_fov_rad(camera.vertical_fov_rad);
    message->set_object(camera.object);
    message->set_is_mounted(camera.is_mounted);
    Put(camera.up, message->mutable_up());
  }
  const bool has_inset = std::any_of(scene.assets->cameras.begin(), scene.assets->cameras.end(),
                                     [](const scene::Camera& camera) { return camera.is_mounted; });
  for (const view::OverlayInfo& info : view::kOverlays) {
    if (info.overlay == view::Overlay::kCamera && !has_inset) continue;  // no button that does nothing
    oos::SceneOverlay* message = assets->add_overlays();
    message->set_name(info.name);
    message->set_key(std::string(1, info.key));
    message->set_what(info.what);
    message->set_is_on_at_start(info.is_on_at_start);
  }
}

void AddMaterialTables(oos::SceneAssets* assets) {
  for (const auto& [name, text] : kShaders) {
    oos::SceneShader* shader = assets->add_shaders();
    shader->set_name(name);
    shader->set_text(text);
  }
  const std::vector<glm::vec2> split_sum = view::SplitSumTable();
  PutTable(view::kSplitSumSize, view::kSplitSumSize, 2, std::span<const float>(&split_sum[0].x, 2 * split_sum.size()),
           assets->mutable_split_sum());
  std::vector<std::uint8_t> wrinkles;  // tilts are from -1 to 1
  for (const glm::vec3& tilt : view::FoilTilts()) {
    for (const float share : {0.5f * tilt.x + 0.5f, 0.5f * tilt.y + 0.5f, tilt.z, 1.0f}) {
      wrinkles.push_back(static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f))));
    }
  }
  PutTable(view::kFoilSize, view::kFoilSize, 4, std::span<const std::uint8_t>(wrinkles), assets->mutable_wrinkles());
  for (const view::LightPanel& panel : view::kPanels) {
    Put(panel.direction_W, assets->mutable_panels());
    for (const float x : {panel.strength, panel.outer, panel.inner}) assets->add_panels(x);
  }
  Put(view::kSunColor, assets->mutable_sun_color());
  Put(view::kHighlight, assets->mutable_highlight());
  using visual_node::Exposure;
  for (const double value : {double{Exposure::kDaylight}, double{Exposure::kLeast}, double{Exposure::kMost},
                             double{Exposure::kGrey}, Exposure::kTimeConstant_s}) {
    assets->add_exposure(value);
  }
}

core::Result<void> AddStars(oos::SceneAssets* assets) {
  const auto stars = space::DecodeStars(space::BrightStarBytes());
  if (!stars) return tl::unexpected(stars.error());
  for (const space::Star& star : *stars) {
    Append(glm::vec3(star.direction_C), assets->mutable_stars());
    Append(glm::vec3(space::Illuminance_lx(star.magnitude) * space::ColorOf(star.color_bv)), assets->mutable_stars());
  }
  return {};
}

// Linear reflectance times the share of land, so that filtering mixes no colour of water into a coast.
core::Result<void> AddEarth(oos::SceneAssets* assets) {
  const auto ground = visual_node::ReadGround();
  if (!ground) return tl::unexpected(ground.error());
  const auto put_grey = [](const picture::Image& map, oos::SceneTable* table) {
    std::vector<std::uint8_t> grey;
    for (std::size_t i = 0; i < map.rgba.size(); i += 4) grey.push_back(map.rgba[i]);
    PutTable(map.width, map.height, 1, std::span<const std::uint8_t>(grey), table);
  };
  PutTable(ground->colors.width, ground->colors.height, 4, std::span<const std::uint8_t>(ground->colors.rgba),
           assets->mutable_land());
  put_grey(ground->clouds, assets->mutable_clouds());
  put_grey(ground->lights, assets->mutable_lights());
  const std::vector<std::uint8_t> fine = visual_node::FineStructure();
  PutTable(visual_node::kFineSize, visual_node::kFineSize * visual_node::kFineSize, 2,
           std::span<const std::uint8_t>(fine), assets->mutable_fine());
  assets->set_moon_radius_m(space::kMoonRadius_m);
  return {};
}

void AddAir(const space::AirFromSpace& air, oos::SceneAir* message) {
  const double bottom_m = air.mapping.shell().bottom, top = air.mapping.shell().top / bottom_m;
  message->set_bottom_m(static_cast<float>(bottom_m));
  message->set_top(static_cast<float>(top));
  message->set_horizon(static_cast<float>(std::sqrt((top - 1.0) * (top + 1.0))));
  message->set_least_mu_s(air.least_mu_s);
  message->set_lowest(air.mapping.lowest());
  Put(air.mie_ratio, message->mutable_mie_ratio());
  message->set_mie_g(air.mie_g);
  for (const int number : {air.num_mu, air.num_nu, air.num_mu_s}) message->add_samples(static_cast<float>(number));
  PutTable(air.num_nu * air.num_mu_s, air.num_mu, 4,
           std::span<const float>(&air.scattering[0].x, 4 * air.scattering.size()), message->mutable_scattering());
  PutTable(space::AirFromSpace::kThroughRows, 2, 3, std::span<const float>(&air.through[0].x, 3 * air.through.size()),
           message->mutable_through());
  PutTable(space::AirFromSpace::kGroundSamples, 1, 3,
           std::span<const float>(&air.ground_light[0].x, 3 * air.ground_light.size()),
           message->mutable_ground_light());
}

}  // namespace

core::Result<oos::SceneAssets> MakeAssets(const scene::Scenario& scenario, const view::Scene& scene,
                                          const space::AirFromSpace& air) {
  oos::SceneAssets assets;
  AddNames(scenario, scene, &assets);
  AddSheets(scene, &assets);
  AddMaterialTables(&assets);
  AddAir(air, assets.mutable_air());
  if (auto added = AddMeshes(scene, &assets); !added) return tl::unexpected(added.error());
  if (auto added = AddStars(&assets); !added) return tl::unexpected(added.error());
  if (auto added = AddEarth(&assets); !added) return tl::unexpected(added.error());
  return assets;
}

}  // namespace scene_stream
