#include "view/scene_mirror.hpp"

#include <algorithm>
#include <cstdio>

#include "core/hand_limits.hpp"

namespace view {
namespace {

constexpr glm::vec3 kWhite{0.92f, 0.94f, 0.97f};
constexpr glm::vec3 kGrey{0.55f, 0.62f, 0.70f};
constexpr glm::vec3 kAmber{1.0f, 0.62f, 0.12f};
constexpr glm::vec3 kCyan{0.25f, 0.80f, 0.95f};
constexpr glm::vec3 kGreen{0.20f, 0.95f, 0.35f};
constexpr glm::vec3 kRed{1.0f, 0.22f, 0.18f};
constexpr float kLampOff = 0.02f;  // least base colour of a lamp: one that is off is dark grey. By eye.

Material MaterialOf(const scene::Material& given) {
  return {given.base_color, given.metallic, given.roughness, glm::vec3(0.0f)};
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
  instance.material.emissive = color;
  instance.is_material_given = true;
}

}  // namespace

SceneMirror::SceneMirror(const scene::Scenario& scenario) : scenario_(scenario), observer_(scenario.place) {
  auto assets = std::make_shared<Assets>();
  assets->cameras = scenario.cameras;
  if (assets->cameras.empty()) assets->cameras.push_back({.name = "default"});
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    assets->instance_names.push_back(object.name);
    auto known = std::find(assets->meshes.begin(), assets->meshes.end(), object.visual_mesh);
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(known - assets->meshes.begin());
    if (known == assets->meshes.end()) assets->meshes.push_back(object.visual_mesh);
    instance.X_WM = object.X_WO;
    instance.material = MaterialOf(object.material);
    instance.is_material_given = object.material.is_given;
    instance.is_visible = !object.visual_mesh.empty();
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
  scene_.assets = std::move(assets);
  pairs_.resize(scenario.pairs.size());
  felt_.resize(scenario.devices.size());
  margins_.resize(scenario.devices.size());
  bool is_arm_simulated = false;
  for (std::size_t role = 0; role < scenario.devices.size(); ++role) {
    const scene::Device& device = scenario.devices[role];
    MoveHand(static_cast<int>(role), device.X_WD_start, device.X_WD_start, device.opening_start_m);
    is_arm_simulated = is_arm_simulated || device.type.starts_with("simulated");
  }
  if (is_arm_simulated) badge_ = "SIMULATED OPERATOR · SIMULATED ARM";
  Refresh(0);
}

void SceneMirror::Apply(const core::PhysicsState& state) {
  for (const core::BodyState& body : state.bodies) {
    if (body.object >= scene_.instances.size()) continue;
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
  felt_[command.role_index] = {glm::length(command.F_Do_W.force_N), now_ns};
}

void SceneMirror::Apply(const core::CollisionMatrix& matrix, std::size_t source, std::int64_t now_ns) {
  if (source < matrices_.size()) matrices_[source] = {matrix, now_ns};
}

void SceneMirror::ApplyBridge(const core::Figures& figures) {
  for (std::size_t role = 0; role < margins_.size(); ++role) {
    const std::string name = core::StiffnessLimitName(scenario_.devices[role].role);
    for (const core::Figure& figure : figures.items) {
      if (figure.name == name) margins_[role] = figure.value;
    }
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
  const std::size_t count = scene_.instances.size();
  if (contacts.sampled_body >= count || contacts.field_body >= count) return;
  pairs_[contacts.pair_index] = {contacts, now_ns, true};
}

void SceneMirror::Apply(const core::LogicStatus& status) {
  status_ = status;
  scene_.step = status.step;
  scene_.is_final = status.is_final;
  scene_.is_failed = status.is_failed;
  for (const core::LampState& state : status.lamps) {
    if (state.object >= scene_.instances.size()) continue;
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
}

void SceneMirror::Refresh(std::int64_t now_ns) {
  scene_.arrows.clear();
  for (const PairContacts& contacts : pairs_) {
    if (!contacts.is_known || !contacts.set.is_in_contact) continue;
    if (now_ns - contacts.received_ns > kContactAge_ns) continue;
    AddArrows(contacts);
  }
  scene_.space = observer_.At(1e-9 * static_cast<double>(scene_.time_ns));
  WriteTexts(now_ns);
}

// A plane's force is evaluated with the bodies' newest poses (architecture D5):
//   gap [m] = n_G . (X_GS p_S - q_G),   force [N] = stiffness * max(0, -gap) along n, from G to S.
// The gap is computed with the hand at the device's pose X_WD, where it penetrates; the arrow starts at the pose X_WC
// at which the hand is drawn.
void SceneMirror::AddArrows(const PairContacts& contacts) {
  const core::ContactSet& set = contacts.set;
  const core::Pose& X_WS = X_WH_[set.sampled_body];
  const core::Pose& X_WG = X_WH_[set.field_body];
  const core::Pose X_GS = X_WG.inverse() * X_WS;
  // Neighbouring planes with similar normals (within 37 degrees, acos 0.8) share an arrow: their summed force at their
  // centre of pressure, p = sum(force_i p_i) / sum(force_i). Limits chosen by eye.
  struct Patch {
    glm::dvec3 force_W{0.0};
    glm::dvec3 weighted_W{0.0};  // sum of force times point
    double weight_N = 0.0;
  };
  core::FixedVector<Patch, core::kMaxContactPlanes> patches;
  for (const core::ContactPlane& plane : set.planes) {
    const glm::dvec3 n_G(plane.n_G);
    const double gap_m = glm::dot(n_G, X_GS * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
    const double force_N = plane.stiffness_N_per_m * -gap_m;
    if (force_N <= 0.0) continue;
    const glm::dvec3 n_W = X_WG.rotate(n_G);
    const glm::dvec3 p_W = scene_.instances[set.sampled_body].X_WM * glm::dvec3(plane.p_S);
    Patch* patch = std::find_if(patches.begin(), patches.end(), [&](const Patch& other) {
      return glm::dot(other.force_W, n_W) > 0.8 * glm::length(other.force_W) &&
             glm::distance(other.weighted_W / other.weight_N, p_W) < kPatch_m;
    });
    if (patch == patches.end()) {
      patches.push_back({});
      patch = &patches.back();
    }
    patch->force_W += force_N * n_W;
    patch->weighted_W += force_N * p_W;
    patch->weight_N += force_N;
  }
  for (const Patch& patch : patches) {
    AddArrow(patch.weighted_W / patch.weight_N, patch.force_W, glm::length(patch.force_W));
  }
  if (!set.planes.empty()) return;
  // A set with a wrench F_So = (f, tau) alone: the arrow starts at the point of the wrench's axis that is nearest to
  // So,
  //   p_SoAxis = f x tau / |f|^2,   the shortest p with p x f = the part of tau perpendicular to f.
  const double square = glm::dot(set.F_So_W.force_N, set.F_So_W.force_N);
  if (square < 1e-12) return;
  const glm::dvec3 p_SoAxis_W = glm::cross(set.F_So_W.force_N, set.F_So_W.torque_Nm) / square;
  AddArrow(scene_.instances[set.sampled_body].X_WM.translation + p_SoAxis_W, set.F_So_W.force_N, std::sqrt(square));
}

void SceneMirror::AddArrow(const glm::dvec3& p_W, const glm::dvec3& direction_W, double force_N) {
  const double norm = glm::length(direction_W);
  if (norm < 1e-9) return;
  const double length_m = std::min(kArrowMax_m, kArrowBase_m + kArrowPerNewton_m * force_N);
  scene_.arrows.push_back({p_W, (length_m / norm) * direction_W, kGreen});
}

void SceneMirror::WriteForces(std::int64_t now_ns) {
  char part[160];
  std::snprintf(part, sizeof part, "t = %.1f s   felt force", 1e-9 * static_cast<double>(scene_.time_ns));
  std::string line = part;
  for (std::size_t role = 0; role < felt_.size(); ++role) {
    const double force_N = now_ns - felt_[role].received_ns > kContactAge_ns ? 0.0 : felt_[role].force_N;
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
  if (deepest->sampled_body >= scenario_.objects.size() || deepest->field_body >= scenario_.objects.size()) return;
  char line[160];
  std::snprintf(line, sizeof line, "%u in contact, deepest %s / %s %.2f mm, %.1f N", num_touching,
                scenario_.objects[deepest->sampled_body].name.c_str(),
                scenario_.objects[deepest->field_body].name.c_str(), 1e3 * static_cast<double>(deepest->depth_m),
                static_cast<double>(deepest->force_N));
  scene_.texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kGrey, line});
}

void SceneMirror::WriteTexts(std::int64_t now_ns) {
  std::vector<TextLine>& texts = scene_.texts;
  texts.clear();
  const std::string& title = scenario_.title.empty() ? scenario_.name : scenario_.title;
  texts.push_back({Anchor::kTopLeft, TextStyle::kBody, kWhite, title});
  texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kGrey, space::FormatInstant(scene_.space.instant)});
  WriteForces(now_ns);
  WriteMargins();
  WriteCollisions(now_ns);
  char line[160];
  if (figures_.t2_state_ms > 0.0) {
    std::snprintf(line, sizeof line, "hand to scene %.1f ms   to image %.1f ms   %.0f fps at scale %.2f   %llu lost",
                  figures_.t2_state_ms, figures_.t2_image_ms, figures_.frames_per_s, figures_.render_scale,
                  static_cast<unsigned long long>(figures_.dropped));
    texts.push_back({Anchor::kTopLeft, TextStyle::kSmall, kCyan, line});
  }
  if (!badge_.empty()) texts.push_back({Anchor::kTopRight, TextStyle::kBadge, kAmber, badge_});
  if (status_.is_failed) {
    texts.push_back({Anchor::kBottomLeft, TextStyle::kTitle, kRed, "failed: " + status_.step});
    texts.push_back({Anchor::kBottomLeft, TextStyle::kBody, kWhite, status_.why});
  } else if (!status_.step.empty() || !status_.hint.empty()) {
    texts.push_back({Anchor::kBottomLeft, TextStyle::kTitle, status_.is_final ? kGreen : kWhite, status_.step});
    if (!status_.hint.empty()) texts.push_back({Anchor::kBottomLeft, TextStyle::kBody, kGrey, status_.hint});
  }
}

}  // namespace view
