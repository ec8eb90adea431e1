#include "view/scene_mirror.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/quaternion.hpp>

#include "core/hand_limits.hpp"
#include "view/hint_anchor.hpp"
#include "view/robot_marks.hpp"
#include "view/tactile_marks.hpp"

namespace view {
namespace {

constexpr glm::vec3 kWhite{0.92f, 0.94f, 0.97f};
constexpr glm::vec3 kGrey{0.55f, 0.62f, 0.70f};
constexpr glm::vec3 kAmber{1.0f, 0.62f, 0.12f};
constexpr glm::vec3 kCyan{0.25f, 0.80f, 0.95f};
constexpr glm::vec3 kGreen{0.20f, 0.95f, 0.35f};
constexpr glm::vec3 kRed{1.0f, 0.22f, 0.18f};
constexpr double kLeastShown_N = 0.05;  // a smaller felt force has no label: it would read 0.0
constexpr double kHintClear_m = 0.05;   // around the part that an instruction names. By eye
constexpr double kAxes_m = 0.1;         // as long as a part or two. By eye
constexpr float kLampGlow = 1.1f;       // of a lamp's lens, for its colour. By eye
constexpr float kLampOff = 0.02f;       // least base colour of a lamp: one that is off is dark grey. By eye.

Material MaterialOf(const scene::Material& given) {
  Material material;
  material.base_color = given.base_color;
  material.metallic = given.metallic;
  material.roughness = given.roughness;
  return material;
}

Sheet FlatSheet(const scene::Object& object) {
  const scene::Sheet& given = *object.sheet;
  const core::Pose X_WS = object.X_WO * given.X_OS;
  Sheet sheet;
  sheet.num_columns = static_cast<std::uint32_t>(given.cells_x + 1);
  sheet.material = MaterialOf(given.material);
  sheet.material.is_foil = sheet.material.metallic > 0.5f;  // a bending sheet of metal is a blanket of insulation
  for (int j = 0; j <= given.cells_y; ++j) {
    for (int i = 0; i <= given.cells_x; ++i) {
      sheet.p_W.emplace_back(X_WS * glm::dvec3((static_cast<double>(i) / given.cells_x - 0.5) * given.size_x_m,
                                               (static_cast<double>(j) / given.cells_y - 0.5) * given.size_y_m, 0.0));
    }
  }
  return sheet;
}

// A glowing lamp shows its own light rather than reflections. The factors are chosen by eye.
void Light(Instance& instance, const glm::vec3& color) {
  instance.material.base_color = glm::max(color * 0.3f, glm::vec3(kLampOff));
  instance.material.metallic = 0.0f;
  instance.material.roughness = 0.3f;
  instance.material.emissive = kLampGlow * color;
  instance.is_material_given = true;
}

std::uint32_t IndexOf(const std::filesystem::path& mesh, Assets* assets) {
  const auto known = std::find(assets->meshes.begin(), assets->meshes.end(), mesh);
  const auto index = static_cast<std::uint32_t>(known - assets->meshes.begin());
  if (known == assets->meshes.end()) assets->meshes.push_back(mesh);
  return index;
}

// Of a hand, the palm's way is that of the hand.
std::vector<bool> ThoseThatMove(const scene::Scenario& scenario) {
  std::vector<bool> move;
  for (const scene::Object& object : scenario.objects) {
    const bool is_palm = object.owner == scene::Owner::kHand && object.part == scene::HandPart::kPalm;
    move.push_back(object.owner == scene::Owner::kPhysics || is_palm);
  }
  return move;
}

}  // namespace

SceneMirror::SceneMirror(const scene::Scenario& scenario)
    : scenario_(scenario),
      observer_(scenario.place),
      history_(ThoseThatMove(scenario)),
      step_goals_(ReadStepGoals(scenario)) {
  auto assets = std::make_shared<Assets>();
  assets->cameras = scenario.cameras;
  if (assets->cameras.empty()) assets->cameras.push_back({.name = "default"});
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    assets->instance_names.push_back(object.name);
    Instance instance;
    instance.mesh = IndexOf(object.visual_mesh, assets.get());
    assets->variants.push_back(object.material.variant);
    instance.X_WM = object.X_WO;
    instance.material = MaterialOf(object.material);
    instance.is_material_given = object.material.is_given;
    has_mesh_.push_back(!object.visual_mesh.empty());
    instance.is_visible = has_mesh_.back();
    instance.is_movable = object.owner != scene::Owner::kFixed;
    if (object.is_lamp) {
      Light(instance, object.lamp_color);
      scene_.lamps.push_back({static_cast<std::uint32_t>(i), object.lamp_color});
    }
    scene_.instances.push_back(instance);
    if (object.sheet) {
      scene_.sheets.push_back(FlatSheet(object));
      scene_.sheets.back().instance = static_cast<std::uint32_t>(i);
      sheet_objects_.push_back(static_cast<std::uint16_t>(i));
    }
    X_WH_.push_back(object.X_WO);
  }
  AddScenery(assets.get());
  scene_.assets = std::move(assets);
  pairs_.resize(scenario.pairs.size());
  felt_.resize(scenario.devices.size());
  robots_.resize(scenario.devices.size());
  tactiles_.resize(scenario.tactiles.size());
  margins_.resize(scenario.devices.size());
  muscles_.resize(scenario.devices.size());
  troubles_.resize(scenario.devices.size());
  bool is_arm_simulated = false;
  for (std::size_t role = 0; role < scenario.devices.size(); ++role) {
    const scene::Device& device = scenario.devices[role];
    MoveHand(static_cast<int>(role), device.X_WD_start, device.X_WD_start, device.opening_start_m);
    is_arm_simulated = is_arm_simulated || device.type.starts_with("simulated");
  }
  if (is_arm_simulated) badge_ = "SIMULATED OPERATOR · SIMULATED ARM";
  Refresh(0);
}

// After the objects, whose indices are the ids on the bus.
void SceneMirror::AddScenery(Assets* assets) {
  const auto add = [&](const std::string& name, const std::filesystem::path& mesh, const scene::Material& material,
                       bool bends = false) {
    Instance instance;
    if (!bends) instance.mesh = IndexOf(mesh, assets);
    assets->variants.push_back(material.variant);
    instance.material = MaterialOf(material);
    instance.is_material_given = material.is_given;
    instance.is_scenery = true;
    has_mesh_.push_back(!mesh.empty());
    instance.is_visible = has_mesh_.back();
    assets->instance_names.push_back(name);
    scene_.instances.push_back(instance);
  };
  for (const scene::Scenery& scenery : scenario_.scenery) {
    add(scenery.name, scenery.mesh, {.variant = scenery.variant}, !scenery.joints.empty());
    scene_.instances.back().X_WM = scenery.X_WM;
  }
  for (const scene::ShownArm& arm : scenario_.shown_arms) {
    arms_.push_back({ArmPosture(arm), arm.role, arm.X_PalmF, scene_.instances.size()});
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      add(arm.LinkName(i), arm.links[i].visual_mesh, arm.links[i].material);
      scene_.instances.back().is_movable = true;
    }
  }
  AddSkins(assets);
}

// Last, because each has a mesh of its own, which nobody else finds by its file.
void SceneMirror::AddSkins(Assets* assets) {
  const std::vector<std::string>& names = assets->instance_names;
  for (std::size_t i = 0; i < scenario_.scenery.size(); ++i) {
    if (scenario_.scenery[i].joints.empty()) continue;
    Skin skin{static_cast<std::uint32_t>(scenario_.objects.size() + i), scenario_.scenery[i].X_WM, {}};
    for (const std::string& joint : scenario_.scenery[i].joints) {
      const auto found = std::find(names.begin(), names.end(), joint);
      skin.goes_with.push_back(static_cast<std::uint32_t>(found - names.begin()));
    }
    scene_.instances[skin.instance].is_movable = true;
    scene_.instances[skin.instance].mesh = static_cast<std::uint32_t>(assets->meshes.size());
    assets->meshes.push_back(scenario_.scenery[i].mesh);
    assets->skins.push_back(std::move(skin));
  }
}

void SceneMirror::MoveArms() {
  for (const Arm& arm : arms_) {
    const int palm = scenario_.devices[static_cast<std::size_t>(arm.role)].palm;
    if (palm < 0) continue;
    const ArmPosture::Links links = arm.posture.At(scene_.instances[static_cast<std::size_t>(palm)].X_WM * arm.X_PalmF);
    for (std::size_t i = 0; i < links.X_WL.size(); ++i) scene_.instances[arm.first + i].X_WM = links.X_WL[i];
  }
}

void SceneMirror::Apply(const core::PhysicsState& state) {
  for (const core::BodyState& body : state.bodies) {
    if (body.object >= X_WH_.size()) continue;
    scene_.instances[body.object].X_WM = body.X_WO;
    X_WH_[body.object] = body.X_WO;
  }
  scene_.time_ns = state.time_ns;
  scene_.direct = state.header.direct;
  scene_.through_physics = state.header.through_physics;
}

void SceneMirror::Apply(const core::SheetState& state) {
  for (std::size_t i = 0; i < sheet_objects_.size(); ++i) {
    Sheet& sheet = scene_.sheets[i];
    if (sheet_objects_[i] != state.object || state.p_W.size() != sheet.p_W.size()) continue;
    std::copy(state.p_W.begin(), state.p_W.end(), sheet.p_W.begin());
    ++sheet.version;
  }
}

void SceneMirror::Apply(const core::HapticProxy& proxy) {
  if (proxy.role_index >= scenario_.devices.size()) return;
  MoveHand(proxy.role_index, proxy.X_WD, proxy.X_WC, proxy.opening_m);
}

void SceneMirror::Apply(const core::DeviceCommand& command, std::int64_t now_ns) {
  if (command.role_index >= felt_.size()) return;
  felt_[command.role_index] = {command.F_Do_W, now_ns};
}

void SceneMirror::Apply(const core::DeviceJoints& joints, std::int64_t now_ns) {
  if (joints.role_index < robots_.size()) robots_[joints.role_index] = {joints, now_ns};
}

void SceneMirror::Apply(const core::TactileState& state, std::int64_t now_ns) {
  if (state.tactile_index < tactiles_.size()) tactiles_[state.tactile_index] = {state, now_ns, true};
}

void SceneMirror::Apply(const core::CollisionMatrix& matrix, std::size_t source, std::int64_t now_ns) {
  if (source < matrices_.size()) matrices_[source] = {matrix, now_ns};
}

void SceneMirror::ApplyBridge(const core::Figures& figures) {
  for (std::size_t role = 0; role < margins_.size(); ++role) {
    const std::string name = core::StiffnessLimitName(scenario_.devices[role].role);
    const std::string muscle = core::MuscleShareName(scenario_.devices[role].role);
    for (const core::Figure& figure : figures.items) {
      if (figure.name == name) margins_[role] = figure.value;
      if (figure.name == muscle) muscles_[role] = figure.value;
    }
  }
  for (const core::Figure& figure : figures.items) {
    if (figure.name == "t1_mean_ms") history_.TakeFigure(SceneHistory::Course::kT1, figure.value);
  }
  TakeGuides(figures);
}

// There are such figures only while a person steers.
void SceneMirror::TakeGuides(const core::Figures& figures) {
  for (std::size_t role = 0; role < scenario_.devices.size(); ++role) {
    const std::string first = core::GuideName(scenario_.devices[role].role, core::kGuideFigures[0]);
    const auto at = std::find_if(figures.items.begin(), figures.items.end(),
                                 [&](const core::Figure& figure) { return figure.name == first; });
    if (figures.items.end() - at < static_cast<std::ptrdiff_t>(core::kGuideFigures.size())) continue;
    scene_.guides.resize(scenario_.devices.size());
    scene_.guides[role] = {static_cast<core::GuideKind>(std::clamp(static_cast<int>(at[0].value), 0, 4)),
                           {at[1].value, at[2].value, at[3].value},
                           {at[4].value, at[5].value, at[6].value}};
    if (!badge_.empty()) badge_ = "SIMULATED ARM";
  }
}

void SceneMirror::Apply(const core::DeviceHealth& health) {
  if (health.role_index >= troubles_.size()) return;
  std::string& trouble = troubles_[health.role_index];
  trouble.clear();
  if (health.status.empty() || health.status == "alive") return;
  const std::string name = health.name.empty() ? "device" : health.name;
  trouble = scenario_.devices[health.role_index].role + ": " + name + " is " + health.status;
  if (!health.why.empty()) trouble += ", " + health.why;
}

void SceneMirror::ApplyHaptic(const core::Figures& figures) {
  for (const core::Figure& figure : figures.items) {
    if (figure.name == "misses") history_.TakeCount(SceneHistory::Course::kLateCycles, figure.value);
  }
}

void SceneMirror::MoveHand(int role, const core::Pose& X_WD, const core::Pose& X_WC, double opening_m) {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner != scene::Owner::kHand || object.role != role) continue;
    scene_.instances[i].X_WM = scene::PartPose(object.part, X_WC, opening_m);
    X_WH_[i] = scene::PartPose(object.part, X_WD, opening_m);
  }
}

void SceneMirror::Apply(const core::ContactSet& contacts, std::int64_t now_ns) {
  if (contacts.pair_index >= pairs_.size()) return;
  const std::size_t count = X_WH_.size();
  if (contacts.sampled_body >= count || contacts.field_body >= count) return;
  pairs_[contacts.pair_index] = {contacts, now_ns, true};
}

void SceneMirror::Apply(const core::LogicStatus& status) {
  if (status.hint != status_.hint) hinted_ = FindNamedObject(status.hint, scene_.assets->instance_names);
  status_ = status;
  scene_.step = status.step;
  scene_.is_final = status.is_final;
  scene_.is_failed = status.is_failed;
  for (const core::LampState& state : status.lamps) {
    if (state.object >= X_WH_.size()) continue;
    const glm::vec3 color(state.red, state.green, state.blue);
    Light(scene_.instances[state.object], color);
    const auto lamp = std::find_if(scene_.lamps.begin(), scene_.lamps.end(),
                                   [&](const Lamp& item) { return item.instance == state.object; });
    if (lamp != scene_.lamps.end()) {
      lamp->color = color;
    } else {
      scene_.lamps.push_back({state.object, color});
    }
  }
}

void SceneMirror::Apply(const LiveFigures& figures) {
  figures_ = figures;
  if (figures.t2_image_ms > 0.0) history_.TakeFigure(SceneHistory::Course::kT2, figures.t2_image_ms);
}

void SceneMirror::Refresh(std::int64_t now_ns) {
  MoveArms();
  MoveSkins(&scene_);
  Remember(now_ns);
  ShowObjects();
  AddOverlays(now_ns);
  scene_.space = observer_.At(1e-9 * static_cast<double>(scene_.time_ns));
  WriteTexts(now_ns);
}

// Contacts and phantoms of a hand: gaps are computed with the hand at the device's pose X_WD, where it penetrates; the
// arrow starts at the pose X_WC at which the hand is drawn.
void SceneMirror::AddContacts(std::int64_t now_ns) {
  std::vector<glm::vec3> depths_W, colors;
  for (const PairContacts& pair : pairs_) {
    if (!pair.is_known || now_ns - pair.received_ns > kContactAge_ns) continue;
    const core::ContactSet& set = pair.set;
    const SeenContact seen{set, X_WH_[set.sampled_body], X_WH_[set.field_body],
                           scene_.instances[set.sampled_body].X_WM};
    if (choices_.has(Overlay::kDistance)) AddDistance(seen, &scene_);
    if (!set.is_in_contact) continue;
    if (choices_.has(Overlay::kContacts)) AddForceArrows(seen, &scene_);
    if (choices_.has(Overlay::kTorques)) AddTorqueRing(seen, &scene_);
    if (choices_.has(Overlay::kDepth)) AddDepthPoints(seen, &depths_W, &colors);
  }
  if (depths_W.empty()) return;
  PointSet points;
  points.p_P = std::make_shared<const std::vector<glm::vec3>>(std::move(depths_W));
  points.colors = std::make_shared<const std::vector<glm::vec3>>(std::move(colors));
  points.size_px = 6.0f;
  scene_.points.push_back(std::move(points));
}

void SceneMirror::AddFeltForces(std::int64_t now_ns) {
  for (std::size_t role = 0; role < felt_.size(); ++role) {
    const int palm = scenario_.devices[role].palm;
    if (palm < 0 || now_ns - felt_[role].received_ns > kContactAge_ns) continue;
    const core::Wrench& F = felt_[role].F_Do_W;
    const glm::dvec3& p_W = scene_.instances[static_cast<std::size_t>(palm)].X_WM.translation;
    const double force_N = glm::length(F.force_N), torque_Nm = glm::length(F.torque_Nm);
    if (force_N > 0.0) scene_.arrows.push_back(ForceArrow(p_W, F.force_N, kAmber));
    if (torque_Nm > kLeastTorque_Nm) scene_.rings.push_back(TorqueRing(p_W, F.torque_Nm, kAmber));
    char text[48];
    std::snprintf(text, sizeof text, "%.1f N  %.2f Nm", force_N, torque_Nm);
    if (force_N > kLeastShown_N || torque_Nm > kLeastTorque_Nm) scene_.labels.push_back({p_W, text, kAmber});
  }
}

void SceneMirror::AddTactiles(std::int64_t now_ns) {
  for (std::size_t i = 0; i < tactiles_.size(); ++i) {
    if (!tactiles_[i].is_known || now_ns - tactiles_[i].received_ns > kContactAge_ns) continue;
    const scene::Tactile& tactile = scenario_.tactiles[i];
    AddTactileRing(tactiles_[i].state, tactile, scene_.instances[static_cast<std::size_t>(tactile.body)].X_WM, &scene_);
  }
}

// A hand where its device is, if the tool is elsewhere.
void SceneMirror::AddPhantoms() {
  for (const scene::Device& device : scenario_.devices) {
    if (device.palm < 0) continue;
    const auto palm = static_cast<std::size_t>(device.palm);
    const core::Pose& X_WD = X_WH_[palm];
    const core::Pose& X_WC = scene_.instances[palm].X_WM;
    const double turned_rad = 2.0 * std::acos(std::min(1.0, std::abs(glm::dot(X_WD.rotation, X_WC.rotation))));
    if (glm::distance(X_WD.translation, X_WC.translation) < kPhantom_m && turned_rad < kPhantom_rad) continue;
    for (const int part : {device.palm, device.jaw_left, device.jaw_right}) {
      if (part < 0) continue;
      const auto i = static_cast<std::size_t>(part);
      if (has_mesh_[i]) scene_.phantoms.push_back({static_cast<std::uint32_t>(i), X_WH_[i], kGreen});
    }
  }
}

// Of W, and of what they help to steer and to place: hands and the selected part, each where it is drawn.
void SceneMirror::AddAxes() {
  std::vector<int> shown{choices_.selected};
  for (const scene::Device& device : scenario_.devices) {
    if (device.palm != choices_.selected) shown.push_back(device.palm);
  }
  scene_.axes.push_back({core::Pose(), kAxes_m});
  scene_.labels.push_back({glm::dvec3(0.0), "W", kWhite});
  for (const int index : shown) {
    if (index < 0 || index >= static_cast<int>(scene_.instances.size())) continue;
    const auto i = static_cast<std::size_t>(index);
    scene_.axes.push_back({scene_.instances[i].X_WM, kAxes_m});
    scene_.labels.push_back({scene_.instances[i].X_WM.translation, scene_.assets->instance_names[i], kWhite});
  }
}

void SceneMirror::AddOverlays(std::int64_t now_ns) {
  scene_.arrows.clear();
  scene_.rings.clear();
  scene_.lines.clear();
  scene_.points.clear();
  scene_.cubes.clear();
  scene_.spheres.clear();
  scene_.labels.clear();
  scene_.axes.clear();
  scene_.phantoms.clear();
  scene_.graphs.clear();
  AddContacts(now_ns);
  if (choices_.has(Overlay::kFeltForce)) AddFeltForces(now_ns);
  if (choices_.has(Overlay::kFeltForce)) AddTactiles(now_ns);
  if (choices_.has(Overlay::kPhantom)) AddPhantoms();
  if (choices_.has(Overlay::kAxes)) AddAxes();
  if (choices_.has(Overlay::kHints) && hinted_ >= 0) {
    scene_.labels.push_back(
        {scene_.instances[static_cast<std::size_t>(hinted_)].X_WM.translation, status_.hint, kWhite, kHintClear_m});
  }
  if (choices_.has(Overlay::kPaths)) history_.AddPaths(&scene_);
  if (const auto goals = step_goals_.find(status_.step);
      choices_.has(Overlay::kPlanned) && goals != step_goals_.end()) {
    AddPlannedWays(scenario_, goals->second, &scene_);
  }
  if (choices_.has(Overlay::kLatency)) history_.AddGraphs(&scene_);
  for (const Robot& robot : robots_) {
    if (choices_.has(Overlay::kRobot) && now_ns - robot.received_ns <= kContactAge_ns) AddRobot(robot.joints, &scene_);
  }
}

void SceneMirror::ShowObjects() {
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const Choices::Object chosen = i < choices_.objects.size() ? choices_.objects[i] : Choices::Object{};
    Instance& instance = scene_.instances[i];
    instance.is_visible = has_mesh_[i] && !chosen.is_hidden;
    instance.opacity = chosen.is_transparent ? kSeeThrough : 1.0f;
    instance.highlight = chosen.is_highlighted || choices_.selected == static_cast<int>(i) ? 0.4f : 0.0f;
  }
  for (Sheet& sheet : scene_.sheets) {
    sheet.is_visible = sheet.instance >= choices_.objects.size() || !choices_.objects[sheet.instance].is_hidden;
  }
}

std::string SceneMirror::LineOf(const core::Collision& collision) const {
  if (collision.sampled_body >= scenario_.objects.size() || collision.field_body >= scenario_.objects.size()) return {};
  char error[32] = "";
  if (collision.force_error_N > 0.0f) {
    std::snprintf(error, sizeof error, " +- %.2g", static_cast<double>(collision.force_error_N));
  }
  char line[192];
  std::snprintf(line, sizeof line, "%s / %s %.2f mm, %.1f%s N", scenario_.objects[collision.sampled_body].name.c_str(),
                scenario_.objects[collision.field_body].name.c_str(), 1e3 * static_cast<double>(collision.depth_m),
                static_cast<double>(collision.force_N), error);
  return line;
}

void SceneMirror::WriteMatrix(std::int64_t now_ns) {
  constexpr std::size_t kMostLines = 12;
  std::vector<const core::Collision*> all;
  for (const Matrix& its : matrices_) {
    if (now_ns - its.received_ns > kContactAge_ns) continue;
    for (const core::Collision& collision : its.matrix.collisions) all.push_back(&collision);
  }
  std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->depth_m > b->depth_m; });
  scene_.texts.push_back(
      {Anchor::kTopRight, TextStyle::kSmall, kWhite, std::to_string(all.size()) + " pairs in contact"});
  for (std::size_t i = 0; i < std::min(all.size(), kMostLines); ++i) {
    scene_.texts.push_back({Anchor::kTopRight, TextStyle::kSmall, kGrey, LineOf(*all[i])});
  }
}

void SceneMirror::WriteSelected(std::int64_t now_ns) {
  if (choices_.selected < 0 || choices_.selected >= static_cast<int>(scenario_.objects.size())) return;
  const auto selected = static_cast<std::size_t>(choices_.selected);
  const scene::Object& object = scenario_.objects[selected];
  const auto write = [&](const glm::vec3& color, const std::string& line) {
    scene_.texts.push_back({Anchor::kTopRight, TextStyle::kSmall, color, line});
  };
  const char* const owners[] = {"fixed", "moved by physics", "part of a hand"};
  write(kHighlight, object.name + (object.group.empty() ? "" : ", group " + object.group) + ", " +
                        owners[static_cast<std::size_t>(object.owner)]);
  char line[160];
  if (object.mass_kg > 0.0) {
    std::snprintf(line, sizeof line, "%.3g kg", object.mass_kg);
    write(kGrey, line);
  } else if (object.density_kg_per_m3 > 0.0) {
    std::snprintf(line, sizeof line, "%.4g kg/m\u00b3", object.density_kg_per_m3);
    write(kGrey, line);
  }
  const core::Pose& X_WO = scene_.instances[selected].X_WM;
  // Rounded here, so that a small negative angle is not "-0.0".
  const glm::dvec3 turn = glm::round(10.0 * glm::degrees(glm::eulerAngles(X_WO.rotation))) / 10.0 + 0.0;
  std::snprintf(line, sizeof line, "at %.4f %.4f %.4f m", X_WO.translation.x, X_WO.translation.y, X_WO.translation.z);
  write(kGrey, line);
  std::snprintf(line, sizeof line, "rpy %.1f %.1f %.1f deg", turn.x, turn.y, turn.z);
  write(kGrey, line);
  bool touches = false;
  for (const Matrix& its : matrices_) {
    if (now_ns - its.received_ns > kContactAge_ns) continue;
    for (const core::Collision& collision : its.matrix.collisions) {
      if (collision.sampled_body != selected && collision.field_body != selected) continue;
      touches = true;
      write(kGreen, LineOf(collision));
    }
  }
  if (!touches) write(kGrey, "touches nothing");
}

void SceneMirror::WriteForces(std::int64_t now_ns) {
  char part[160];
  std::snprintf(part, sizeof part, "t = %.1f s   felt force", 1e-9 * static_cast<double>(scene_.time_ns));
  std::string line = part;
  scene_.felt_N.resize(felt_.size());
  for (std::size_t role = 0; role < felt_.size(); ++role) {
    const bool is_known = now_ns - felt_[role].received_ns <= kContactAge_ns;
    const double force_N = is_known ? glm::length(felt_[role].F_Do_W.force_N) : 0.0;
    scene_.felt_N[role] = force_N;
    std::snprintf(part, sizeof part, "%s %.1f N", role > 0 ? " /" : "", force_N);
    line += part;
  }
  scene_.texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kGrey, line});
}

void SceneMirror::WriteMargins() {
  std::string line;
  double least = 1.0;
  for (const double margin : margins_) {
    if (margin <= 0.0) continue;
    char part[32];
    std::snprintf(part, sizeof part, "%s%.1f", line.empty() ? "" : " / ", margin);
    line += part;
    least = std::min(least, margin);
  }
  if (line.empty()) return;
  line = "stable up to " + line + " times the hand's stiffness";
  scene_.texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, least < 1.0 ? kAmber : kGrey, line});
}

void SceneMirror::WriteMuscles() {
  for (std::size_t role = 0; role < muscles_.size(); ++role) {
    if (!muscles_[role]) continue;
    const bool is_known = *muscles_[role] >= 0.0;
    char line[96];
    std::snprintf(line, sizeof line, "%s: grip by muscles (SIMULATED)  %.0f %%", scenario_.devices[role].role.c_str(),
                  100.0 * std::max(0.0, *muscles_[role]));
    scene_.texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, is_known ? kCyan : kRed,
                            is_known ? line : scenario_.devices[role].role + ": too many faults of muscle signals"});
  }
}

void SceneMirror::WriteCollisions(std::int64_t now_ns) {
  unsigned num_touching = 0;
  const core::Collision* deepest = nullptr;
  for (const Matrix& its : matrices_) {
    if (now_ns - its.received_ns > kContactAge_ns) continue;
    num_touching += its.matrix.num_touching;
    for (const core::Collision& collision : its.matrix.collisions) {
      if (deepest == nullptr || collision.depth_m > deepest->depth_m) deepest = &collision;
    }
  }
  if (deepest == nullptr) return;
  const std::string pair = LineOf(*deepest);
  if (pair.empty()) return;
  scene_.texts.push_back(
      {Anchor::kTopLeft, TextStyle::kSmall, kGrey, std::to_string(num_touching) + " in contact, deepest " + pair});
}

void SceneMirror::WriteTexts(std::int64_t now_ns) {
  std::vector<TextLine>& texts = scene_.texts;
  texts.clear();
  const std::string& title = scenario_.title.empty() ? scenario_.name : scenario_.title;
  texts.push_back({Anchor::kTopLeft, TextStyle::kBody, kWhite, title});
  texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kGrey, space::FormatInstant(scene_.space.instant)});
  WriteForces(now_ns);
  WriteMargins();
  WriteMuscles();
  WriteCollisions(now_ns);
  for (std::size_t i = 0; i < tactiles_.size(); ++i) {
    if (!tactiles_[i].is_known || now_ns - tactiles_[i].received_ns > kContactAge_ns) continue;
    texts.push_back(TactileLine(tactiles_[i].state, scenario_.tactiles[i]));
  }
  char line[160];
  if (figures_.t2_state_ms > 0.0) {
    std::snprintf(line, sizeof line, "hand to scene %.1f ms   to image %.1f ms   %.0f fps at scale %.2f   %llu lost",
                  figures_.t2_state_ms, figures_.t2_image_ms, figures_.frames_per_s, figures_.render_scale,
                  static_cast<unsigned long long>(figures_.dropped));
    texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kCyan, line});
  }
  if (!badge_.empty()) texts.push_back({Anchor::kTopRight, TextStyle::kBadge, kAmber, badge_});
  if (choices_.has(Overlay::kClock)) history_.AddClock(&scene_);
  if (choices_.has(Overlay::kSteps)) history_.AddSteps(&scene_);
  if (choices_.has(Overlay::kMatrix)) WriteMatrix(now_ns);
  WriteSelected(now_ns);
  for (const std::string& trouble : troubles_) {
    if (!trouble.empty()) texts.push_back({Anchor::kBottomLeft, TextStyle::kBody, kRed, trouble});
  }
  if (status_.is_failed) {
    texts.push_back({Anchor::kBottomLeft, TextStyle::kTitle, kRed, "failed: " + status_.step});
    texts.push_back({Anchor::kBottomLeft, TextStyle::kBody, kWhite, status_.why});
  } else if (!status_.step.empty() || !status_.hint.empty()) {
    texts.push_back({Anchor::kBottomLeft, TextStyle::kTitle, status_.is_final ? kGreen : kWhite, status_.step});
    if (!status_.hint.empty()) texts.push_back({Anchor::kBottomLeft, TextStyle::kBody, kGrey, status_.hint});
  }
}

}  // namespace view
