#include "collision/resolution/choose_resolutions.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "scene/load_scenario.hpp"
#include "vps/asset/choose_resolution.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/part_size.hpp"
#include "vps/mesh/thicken_sheet.hpp"

namespace collision {
namespace {

class Chooser {
 public:
  explicit Chooser(scene::Scenario* scenario)
      : scenario_(*scenario), method_(vps::MethodFromName(scenario->method).value_or(vps::Method::kPaper)) {}

  tl::expected<std::vector<ResolutionNote>, std::vector<scene::Diagnostic>> Run() {
    for (scene::Object& object : scenario_.objects) {
      if (!object.is_resolution_chosen) continue;
      object.voxel_size_m = 0.0;
      object.num_points = 0;
    }
    Measure();
    if (!diagnostics_.empty()) return tl::unexpected(std::move(diagnostics_));
    for (scene::Pair& pair : scenario_.pairs) ChooseSides(&pair);
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) ChooseVoxelOf(i);
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) ChoosePointsOf(i);  // which stand a voxel apart
    std::stable_sort(notes_.begin(), notes_.end(), [](const auto& a, const auto& b) { return a.object < b.object; });
    return std::move(notes_);
  }

 private:
  [[nodiscard]] bool IsChosen(std::size_t object) const { return scenario_.objects[object].is_resolution_chosen; }
  [[nodiscard]] const vps::PartSize& SizeOf(std::size_t object) const {
    const scene::Object& o = scenario_.objects[object];
    return sizes_.at({o.collision_mesh.string(), o.sheet_thickness_m});
  }

  void Measure() {
    for (const scene::Pair& pair : scenario_.pairs) {
      if (!IsChosen(pair.sampled) && !IsChosen(pair.field)) continue;
      for (const std::uint16_t i : {pair.sampled, pair.field}) MeasureMeshOf(scenario_.objects[i]);
    }
  }

  void MeasureMeshOf(const scene::Object& object) {
    const Key key{object.collision_mesh.string(), object.sheet_thickness_m};
    if (sizes_.contains(key)) return;
    const bool is_sheet = object.sheet_thickness_m > 0.0;
    const auto checked = vps::LoadCheckedMesh(object.collision_mesh, 1.0, is_sheet);
    if (!checked) {
      diagnostics_.push_back({object.location, "object '" + object.name + "': its voxels and points cannot be chosen",
                              checked.error().detail, "mend the mesh (docs/reference/meshes.md says what can be)"});
      sizes_[key] = {};  // reported once
      return;
    }
    sizes_[key] =
        vps::MeasurePart(is_sheet ? vps::ThickenSheet(checked->mesh, object.sheet_thickness_m) : checked->mesh);
  }

  void ChooseSides(scene::Pair* pair) {
    if (!IsChosen(pair->sampled) || !IsChosen(pair->field)) return;
    if (vps::IsFirstSampled(SizeOf(pair->field), SizeOf(pair->sampled))) std::swap(pair->sampled, pair->field);
    notes_.push_back({pair->sampled, "sampled against '" + scenario_.objects[pair->field].name +
                                         "' (smallest feature " + FeatureOf(pair->sampled) + ", of the other " +
                                         FeatureOf(pair->field) + ")"});
  }

  [[nodiscard]] std::string FeatureOf(std::size_t object) const {
    return vps::Millimetres(vps::SmallestFeature_m(SizeOf(object)));
  }

  void ChooseVoxelOf(std::size_t i) {
    if (!IsChosen(i)) return;
    scene::Object& object = scenario_.objects[i];
    std::string text;
    for (const scene::Pair& pair : scenario_.pairs) {
      if (pair.field != i) continue;
      const vps::ChosenVoxel voxel = vps::ChooseVoxel(
          SizeOf(i), SizeOf(pair.sampled), {method_, pair.accuracy, scene::kMinVoxelSize_m, scene::kMaxVoxelSize_m});
      if (object.voxel_size_m > 0.0 && voxel.size_m >= object.voxel_size_m) continue;
      object.voxel_size_m = voxel.size_m;
      text = "voxels of " + vps::Millimetres(voxel.size_m) + " (" + voxel.reason + "; against '" +
             scenario_.objects[pair.sampled].name + "')";
    }
    if (!text.empty()) notes_.push_back({i, text});
  }

  void ChoosePointsOf(std::size_t i) {
    if (!IsChosen(i)) return;
    scene::Object& object = scenario_.objects[i];
    std::string text;
    for (const scene::Pair& pair : scenario_.pairs) {
      if (pair.sampled != i) continue;
      const scene::Object& field = scenario_.objects[pair.field];
      const std::uint32_t num_points = vps::ChoosePoints(SizeOf(i).area_m2, field.voxel_size_m);
      if (num_points <= object.num_points) continue;
      object.num_points = num_points;
      text = std::to_string(num_points) + " points (a voxel of '" + field.name + "' apart, 1,000 to 100,000)";
    }
    if (!text.empty()) notes_.push_back({i, text});
  }

  using Key = std::pair<std::string, double>;  // mesh file and thickness of a sheet

  scene::Scenario& scenario_;
  vps::Method method_;
  std::map<Key, vps::PartSize> sizes_;
  std::vector<ResolutionNote> notes_;
  std::vector<scene::Diagnostic> diagnostics_;
};

}  // namespace

tl::expected<std::vector<ResolutionNote>, std::vector<scene::Diagnostic>> ChooseResolutions(scene::Scenario* scenario) {
  return Chooser(scenario).Run();
}

tl::expected<scene::Scenario, std::vector<scene::Diagnostic>> LoadResolvedScenario(const std::filesystem::path& path) {
  auto scenario = scene::LoadScenario(path);
  if (!scenario) return scenario;
  if (auto chosen = ChooseResolutions(&*scenario); !chosen) return tl::unexpected(std::move(chosen.error()));
  return scenario;
}

}  // namespace collision
