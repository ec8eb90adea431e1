#include "tools/web_bridge/scene_stream/frame.hpp"

#include "tools/web_bridge/scene_stream/numbers.hpp"
#include "view/appearance/sheet_mesh.hpp"

namespace scene_stream {
namespace {

// The light of the surroundings is computed anew when the sun has moved by 0.06 degrees against the scene, about a
// second of an orbit.
constexpr float kSameLight = 1e-3f;

bool IsAlike(const view::EnvironmentLight& a, const view::EnvironmentLight& b) {
  return glm::distance(a.sun_direction_W, b.sun_direction_W) + glm::distance(a.earth_direction_W, b.earth_direction_W) +
             glm::distance(a.sun, b.sun) + glm::distance(a.earth, b.earth) <
         kSameLight;
}

bool IsShown(const view::Instance& instance) {
  return instance.is_visible && instance.opacity == 1.0f && instance.highlight == 0.0f && !instance.is_material_given &&
         instance.material.emissive == glm::vec3(0.0f);
}

void Put(const view::Label& label, oos::SceneLabel* message) {
  scene_stream::Put(label.p_W, message->mutable_at());
  message->set_text(label.text);
  scene_stream::Put(label.color, message->mutable_color());
}

}  // namespace

std::vector<std::string> NamesOf(const view::Choices& choices, const std::vector<std::string>& objects) {
  std::vector<std::string> names;
  for (const view::OverlayInfo& info : view::kOverlays) {
    if (choices.has(info.overlay)) names.push_back(std::string("overlay.") + info.name);
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (static_cast<int>(i) == choices.selected) names.push_back("select." + objects[i]);
    if (i >= choices.objects.size()) continue;
    if (choices.objects[i].is_hidden) names.push_back("hide." + objects[i]);
    if (choices.objects[i].is_transparent) names.push_back("transparent." + objects[i]);
    if (choices.objects[i].is_highlighted) names.push_back("highlight." + objects[i]);
  }
  return names;
}

void FrameMaker::PutPoints(const view::SharedPoints& points, oos::ScenePoints* message) {
  if (points == nullptr) return;
  if (points->size() <= PointBlocks::kMostHere) {
    Append(std::span<const glm::vec3>(*points), message->mutable_here());
  } else {
    message->set_block(blocks_->NumberOf(points));
  }
}

void FrameMaker::AddLooks(const view::Scene& scene, oos::SceneFrame* frame) const {
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    Append(instance.X_WM, frame->mutable_poses());
    if (instance.posture != nullptr) {
      oos::ScenePosture* posture = frame->add_postures();
      posture->set_instance(static_cast<std::uint32_t>(i));
      for (const core::Pose& X_MJ : *instance.posture) Append(X_MJ, posture->mutable_joints());
    }
    if (IsShown(instance)) continue;
    oos::SceneLook* look = frame->add_looks();
    look->set_instance(static_cast<std::uint32_t>(i));
    scene_stream::Put(instance.material, look->mutable_surface());
    look->set_is_surface_given(instance.is_material_given);
    look->set_is_hidden(!instance.is_visible);
    look->set_opacity(instance.opacity);
    look->set_highlight(instance.highlight);
  }
  for (const view::Lamp& lamp : scene.lamps) {
    oos::SceneLamp* message = frame->add_lamps();
    message->set_instance(lamp.instance);
    scene_stream::Put(lamp.color, message->mutable_color());
  }
}

void FrameMaker::AddSky(const view::Scene& scene, oos::SceneSky* sky) {
  const space::Surroundings& space = scene.space;
  scene_stream::Put(space.sun_direction_W, sky->mutable_sun_direction());
  scene_stream::Put(space.moon_position_W, sky->mutable_moon());
  scene_stream::Put(space.X_WE, sky->mutable_earth());
  scene_stream::Put(space.R_WC, sky->mutable_celestial());
  scene_stream::Put(space::SunLight(space, air_), sky->mutable_sunlight());
  const view::EnvironmentLight light = view::LightOf(space, air_);
  if (!is_irradiance_known_ || !IsAlike(light, irradiance_of_)) {
    irradiance_ = view::Irradiance(light);
    irradiance_of_ = light;
    is_irradiance_known_ = true;
  }
  scene_stream::Put(light.sun, sky->mutable_sun());
  scene_stream::Put(light.earth_direction_W, sky->mutable_earth_direction_sine());
  sky->add_earth_direction_sine(light.earth_sine);
  scene_stream::Put(light.earth, sky->mutable_earth_light());
  scene_stream::Put(light.panels, sky->mutable_panels());
  scene_stream::Put(light.everywhere, sky->mutable_everywhere());
  for (const glm::vec3& term : irradiance_) scene_stream::Put(term, sky->mutable_irradiance());
}

void FrameMaker::AddOverlays(const view::Scene& scene, oos::SceneFrame* frame) {
  for (const view::Arrow& arrow : scene.arrows) {
    oos::SceneArrow* message = frame->add_arrows();
    scene_stream::Put(arrow.p_WTail, message->mutable_tail());
    scene_stream::Put(arrow.vector_W, message->mutable_vector());
    scene_stream::Put(arrow.color, message->mutable_color());
  }
  for (const view::RingArrow& ring : scene.rings) {
    oos::SceneRing* message = frame->add_rings();
    scene_stream::Put(ring.p_WCentre, message->mutable_centre());
    scene_stream::Put(ring.axis_W, message->mutable_axis());
    message->set_radius_m(ring.radius_m);
    message->set_sweep_rad(ring.sweep_rad);
    scene_stream::Put(ring.color, message->mutable_color());
  }
  for (const view::LineStrip& line : scene.lines) {
    oos::SceneLine* message = frame->add_lines();
    if (line.p_W != nullptr) {
      Append(std::span<const glm::vec3>(*line.p_W), message->mutable_points()->mutable_here());
    }
    scene_stream::Put(line.color, message->mutable_color());
    message->set_width_px(line.width_px);
    message->set_opacity(line.opacity);
  }
  for (const view::PointSet& set : scene.points) {
    oos::SceneDots* message = frame->add_dots();
    scene_stream::Put(set.X_WP, message->mutable_pose());
    PutPoints(set.p_P, message->mutable_points());
    if (set.colors != nullptr) PutPoints(set.colors, message->mutable_colors());
    scene_stream::Put(set.color, message->mutable_color());
    message->set_size_px(set.size_px);
    message->set_most_m(set.most_m);
    message->set_shows_through(set.shows_through);
  }
  for (const view::Cubes& cubes : scene.cubes) {
    oos::SceneGrains* message = frame->add_grains();
    scene_stream::Put(cubes.X_WP, message->mutable_pose());
    PutPoints(cubes.p_P, message->mutable_points());
    message->set_size_m(cubes.edge_m);
    scene_stream::Put(cubes.color, message->mutable_color());
    message->set_opacity(1.0f);
  }
  for (const view::Spheres& spheres : scene.spheres) {
    if (spheres.p_P_radius_m == nullptr) continue;
    oos::SceneGrains* message = frame->add_grains();
    scene_stream::Put(spheres.X_WP, message->mutable_pose());
    message->mutable_points()->set_block(blocks_->NumberOf(spheres.p_P_radius_m));
    message->set_are_spheres(true);
    scene_stream::Put(spheres.color, message->mutable_color());
    message->set_opacity(spheres.opacity);
  }
  for (const view::Label& label : scene.labels) Put(label, frame->add_labels());
  for (const view::Axes& axes : scene.axes) {
    oos::SceneAxes* message = frame->add_axes();
    scene_stream::Put(axes.X_WA, message->mutable_pose());
    message->set_length_m(axes.length_m);
  }
  for (const view::Phantom& phantom : scene.phantoms) {
    oos::ScenePhantom* message = frame->add_phantoms();
    message->set_instance(phantom.instance);
    scene_stream::Put(phantom.X_WM, message->mutable_pose());
    scene_stream::Put(phantom.color, message->mutable_color());
    message->set_opacity(phantom.opacity);
  }
}

oos::SceneFrame FrameMaker::Make(const view::Scene& scene, const view::Choices& choices) {
  oos::SceneFrame frame;
  frame.set_time_ns(scene.time_ns);
  frame.set_step(scene.step);
  frame.set_is_final(scene.is_final);
  frame.set_is_failed(scene.is_failed);
  AddLooks(scene, &frame);
  AddSky(scene, frame.mutable_sky());
  AddOverlays(scene, &frame);
  for (const view::Graph& graph : scene.graphs) {
    oos::SceneGraph* message = frame.add_graphs();
    message->set_title(graph.title);
    for (const float value : graph.values) message->add_values(value);
    message->set_most(graph.most);
    scene_stream::Put(graph.color, message->mutable_color());
  }
  for (const view::TextLine& line : scene.texts) {
    oos::SceneText* message = frame.add_texts();
    message->set_anchor(static_cast<std::uint32_t>(line.anchor));
    message->set_style(static_cast<std::uint32_t>(line.style));
    scene_stream::Put(line.color, message->mutable_color());
    message->set_text(line.text);
  }
  for (std::string& name : NamesOf(choices, scene.assets->instance_names)) frame.add_choices(std::move(name));
  frame.set_sheets_version(VersionOfSheets(scene));
  return frame;
}

std::uint64_t FrameMaker::VersionOfSheets(const view::Scene& scene) {
  std::uint64_t sum = 1;
  for (const view::Sheet& sheet : scene.sheets) sum += 2 * sheet.version + (sheet.is_visible ? 1 : 0);
  return sum;
}

oos::SceneSheets FrameMaker::Sheets(const view::Scene& scene) {
  oos::SceneSheets message;
  message.set_version(VersionOfSheets(scene));
  for (const view::Sheet& sheet : scene.sheets) {
    const vps::VisualPrimitive mesh = view::MakeSheetMesh(sheet);
    oos::SceneSheet* one = message.add_sheets();
    one->set_instance(sheet.instance);
    one->set_is_hidden(!sheet.is_visible);
    scene_stream::Put(sheet.material, one->mutable_surface());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      Append(mesh.positions[i], one->mutable_vertices());
      Append(mesh.normals[i], one->mutable_vertices());
    }
    Append(std::span<const std::uint32_t>(mesh.indices), one->mutable_indices());
  }
  return message;
}

}  // namespace scene_stream
