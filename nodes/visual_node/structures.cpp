#include "nodes/visual_node/structures.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "vps/asset/cooked_object.hpp"
#include "vps/asset/list_structures.hpp"

namespace visual_node {
namespace {

// By eye: with fewer spheres the level says little of the shape, with more they hide each other.
constexpr std::size_t kFewestSpheres = 12;

constexpr glm::vec3 kPointColor{0.95f, 0.10f, 0.06f};
constexpr glm::vec3 kSphereColor{1.0f, 0.80f, 0.10f};
constexpr glm::vec3 kVoxelColor{0.30f, 0.62f, 0.85f};
constexpr glm::vec3 kNoteColor{0.75f, 0.80f, 0.86f};

view::SharedPoints Places(const std::vector<vps::SurfacePoint>& points) {
  std::vector<glm::vec3> places;
  for (const vps::SurfacePoint& point : points) places.emplace_back(point.p_m);
  return std::make_shared<const std::vector<glm::vec3>>(std::move(places));
}

void TakeLevel(const std::vector<std::vector<vps::TreeSphere>>& levels, Structures* structures) {
  if (levels.empty()) return;
  const auto enough =
      std::find_if(levels.begin(), levels.end() - 1, [](const auto& level) { return level.size() >= kFewestSpheres; });
  structures->level = static_cast<std::size_t>(enough - levels.begin());
  structures->num_levels = levels.size();
  std::vector<glm::vec4> spheres;
  for (const vps::TreeSphere& sphere : *enough) spheres.emplace_back(glm::vec3(sphere.centre_m), sphere.radius_m);
  structures->spheres_O = std::make_shared<const std::vector<glm::vec4>>(std::move(spheres));
}

// Median distance of some points to their nearest ones.
float SpacingOf(const std::vector<glm::vec3>& places) {
  constexpr std::size_t kProbes = 101;
  std::vector<float> nearest;
  for (std::size_t i = 0; i < places.size(); i += 1 + places.size() / kProbes) {
    float least = 1e6f;
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (k != i) least = std::min(least, glm::distance(places[i], places[k]));
    }
    nearest.push_back(least);
  }
  if (nearest.empty()) return 0.0f;
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

std::size_t CountOf(const auto& shared) {
  return shared == nullptr ? 0 : shared->size();
}

}  // namespace

Structures BuildStructures(const scene::Scenario& scenario, std::size_t object) {
  const scene::Object& given = scenario.objects[object];
  Structures structures;
  vps::CookParameters parameters{given.voxel_size_m, given.num_points};
  parameters.method = vps::MethodFromName(scenario.method).value_or(vps::Method::kPaper);
  parameters.sheet_half_thickness_m = 0.5 * given.sheet_thickness_m;
  if (given.collision_mesh.empty() || (given.voxel_size_m <= 0.0 && given.num_points == 0)) {
    structures.error = "no part of collisions";
    return structures;
  }
  const auto cooked = vps::Cook(given.collision_mesh, parameters);
  if (!cooked) {
    structures.error = cooked.error().detail;
    return structures;
  }
  structures.voxel_size_m = given.voxel_size_m;
  const auto share_voxels = [&](const auto& field) {
    structures.voxels_O = std::make_shared<const std::vector<glm::vec3>>(vps::SurfaceVoxelsOf(field));
  };
  if (cooked->field) share_voxels(*cooked->field);
  if (cooked->voxmap) share_voxels(*cooked->voxmap);
  if (cooked->samples) {
    structures.points_O = Places(vps::PointsOf(*cooked->samples));
    TakeLevel(vps::LevelsOf(*cooked->samples), &structures);
  }
  if (cooked->points) {
    structures.points_O = Places(vps::PointsOf(*cooked->points));
    TakeLevel(vps::LevelsOf(*cooked->points), &structures);
  }
  if (structures.points_O != nullptr) structures.spacing_m = SpacingOf(*structures.points_O);
  return structures;
}

StructureShow::~StructureShow() {
  if (thread_.joinable()) thread_.join();
}

bool StructureShow::IsWanted(const view::Choices& choices) {
  return choices.selected >= 0 && (choices.has(view::Overlay::kSamples) || choices.has(view::Overlay::kTree) ||
                                   choices.has(view::Overlay::kVoxels));
}

// Only while no thread runs.
void StructureShow::Begin(int object) {
  if (thread_.joinable()) thread_.join();
  object_ = object;
  built_.reset();
  is_done_ = false;
  thread_ = std::thread([this, object] {
    setpriority(PRIO_PROCESS, 0, 19);
    in_work_ = BuildStructures(scenario_, static_cast<std::size_t>(object));
    is_done_ = true;
  });
}

void StructureShow::AddTo(const view::Choices& choices, view::Scene* scene) {
  const bool is_at_work = object_ >= 0 && !built_;
  if (is_at_work && is_done_) built_ = std::exchange(in_work_, {});
  if (!IsWanted(choices) || choices.selected >= static_cast<int>(scenario_.objects.size())) return;
  if (choices.selected != object_ && (object_ < 0 || built_)) Begin(choices.selected);
  Show(choices, scene);
}

void StructureShow::BuildAndAddTo(const view::Choices& choices, view::Scene* scene) {
  if (!IsWanted(choices) || choices.selected >= static_cast<int>(scenario_.objects.size())) return;
  if (choices.selected != object_) {
    object_ = choices.selected;
    built_ = BuildStructures(scenario_, static_cast<std::size_t>(object_));
  }
  Show(choices, scene);
}

void StructureShow::Show(const view::Choices& choices, view::Scene* scene) const {
  const std::string& name = scenario_.objects[static_cast<std::size_t>(choices.selected)].name;
  const auto write = [&](const std::string& line) {
    scene->texts.push_back({view::Anchor::kTopRight, view::TextStyle::kSmall, kNoteColor, line});
  };
  if (choices.selected != object_ || !built_) return write(name + ": points, spheres and voxels are built");
  if (!built_->error.empty()) return write(name + ": " + built_->error);
  view::Instance& instance = scene->instances[static_cast<std::size_t>(object_)];
  instance.highlight = 0.0f;  // it would tint them
  const core::Pose& X_WO = instance.X_WM;
  char line[160];
  if (choices.has(view::Overlay::kSamples)) {
    constexpr float kShare = 0.45f;  // of the spacing: neighbours stay apart
    view::PointSet points{X_WO, built_->points_O, nullptr, kPointColor, 6.0f * kShare, kShare * built_->spacing_m};
    points.shows_through = false;
    if (built_->points_O != nullptr) scene->points.push_back(std::move(points));
    std::snprintf(line, sizeof line, "%s: %zu points", name.c_str(), CountOf(built_->points_O));
    write(line);
  }
  if (choices.has(view::Overlay::kTree)) {
    if (built_->spheres_O != nullptr) scene->spheres.push_back({X_WO, built_->spheres_O, kSphereColor});
    std::snprintf(line, sizeof line, "%s: %zu spheres of level %zu of %zu", name.c_str(), CountOf(built_->spheres_O),
                  std::min(built_->level + 1, built_->num_levels), built_->num_levels);
    write(line);
  }
  if (choices.has(view::Overlay::kVoxels)) {
    if (built_->voxels_O != nullptr) {
      scene->cubes.push_back({X_WO, built_->voxels_O, built_->voxel_size_m, kVoxelColor});
    }
    std::snprintf(line, sizeof line, "%s: %zu voxels of %.3g mm", name.c_str(), CountOf(built_->voxels_O),
                  1e3 * built_->voxel_size_m);
    write(line);
  }
}

}  // namespace visual_node
