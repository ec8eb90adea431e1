#include "collision/owned_world.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <tuple>

#include "vps/asset/cooked_object.hpp"

namespace collision {
namespace {

// Empty sets sent after a contact. Not derived: all have to be lost for its end to go unnoticed.
constexpr int kEmptySets = 5;
// Of one place that SurfaceWalk reads. Measured: 25 to 35 ns on a Xeon of 2021, one core, AVX-512.
constexpr double kPlaceTime_us = 0.03;

vps::Method MethodOf(const scene::Scenario& scenario) {
  return vps::MethodFromName(scenario.method).value_or(vps::Method::kPaper);
}

// Reports the start of each stage and every tenth of it as a line.
vps::Progress MakeProgress(const std::string& name, const std::function<void(const std::string&)>& report) {
  if (!report) return {};
  return [name, report, reported = -1.0](std::string_view stage, double fraction) mutable {
    if (fraction < reported + 0.1 && fraction >= reported) return;
    reported = fraction;
    char line[160];
    std::snprintf(line, sizeof line, "cook %s: %.*s %3.0f %%", name.c_str(), static_cast<int>(stage.size()),
                  stage.data(), 100.0 * fraction);
    report(line);
  };
}

class Cooker {
 public:
  Cooker(const scene::Scenario& scenario, core::ParallelFor& workers, const Options& options)
      : scenario_(scenario),
        workers_(workers),
        options_(options),
        is_sampled_(scenario.objects.size()),
        is_field_(scenario.objects.size()) {}

  void Require(const scene::Pair& pair) {
    is_sampled_[pair.sampled] = 1;
    is_field_[pair.field] = 1;
  }

  // Null when no pair requires the object. Objects of one mesh, voxel size and number of points share their structures.
  core::Result<std::shared_ptr<const vps::CookedObject>> Cook(std::size_t i) {
    const scene::Object& object = scenario_.objects[i];
    vps::CookParameters parameters;
    parameters.method = MethodOf(scenario_);
    parameters.sheet_half_thickness_m = 0.5 * object.sheet_thickness_m;
    if (is_field_[i] != 0) parameters.voxel_size_m = object.voxel_size_m;
    if (is_sampled_[i] != 0) parameters.num_points = object.num_points;
    if (parameters.voxel_size_m <= 0.0 && parameters.num_points == 0) return nullptr;
    const Key key{object.collision_mesh.string(), parameters.voxel_size_m, parameters.num_points,
                  parameters.sheet_half_thickness_m};
    std::shared_ptr<const vps::CookedObject>& data = cooked_[key];
    if (data != nullptr) return data;
    auto result = vps::Cook(object.collision_mesh, parameters, options_.cache,
                            MakeProgress(object.name, options_.progress), &workers_);
    if (!result) return core::Fail(result.error().code, "object '" + object.name + "': " + result.error().detail);
    data = std::make_shared<const vps::CookedObject>(std::move(*result));
    return data;
  }

 private:
  using Key = std::tuple<std::string, double, std::uint32_t, double>;

  const scene::Scenario& scenario_;
  core::ParallelFor& workers_;
  const Options& options_;
  std::vector<std::uint8_t> is_sampled_;
  std::vector<std::uint8_t> is_field_;
  std::map<Key, std::shared_ptr<const vps::CookedObject>> cooked_;
};

vps::PairDescription Describe(const scene::Scenario& scenario, const scene::Pair& pair) {
  const bool is_of_hand = scenario.objects[pair.sampled].owner == scene::Owner::kHand ||
                          scenario.objects[pair.field].owner == scene::Owner::kHand;
  vps::PairDescription row;
  row.sampled = pair.sampled;
  row.field = pair.field;
  row.stiffness_N_per_m = is_of_hand ? scenario.coupling.stiffness_N_per_m : pair.stiffness_N_per_m;
  row.damping_N_s_per_m = pair.damping_N_s_per_m;
  row.friction = pair.friction;
  row.look_ahead_m = pair.look_ahead_m;
  row.accuracy = pair.accuracy;
  row.most_places = static_cast<std::uint32_t>(std::max(1.0, pair.budget_us / kPlaceTime_us));
  row.is_active = pair.is_active;
  // Jaws grip by the penalty integral's depth and direction (HapticNode::JawForce_N), which gaps do not give.
  const auto is_palm = [&](std::uint16_t object) {
    const scene::Object& o = scenario.objects[object];
    return o.owner == scene::Owner::kHand && o.part == scene::HandPart::kPalm;
  };
  row.has_gaps = scenario.coupling.type == "god_object" && (is_palm(pair.sampled) || is_palm(pair.field));
  return row;
}

}  // namespace

core::Result<OwnedWorld> BuildOwnedWorld(const scene::Scenario& scenario, scene::PairOwner owner,
                                         core::ParallelFor& workers, const Options& options) {
  OwnedWorld owned;
  vps::WorldDescription description;
  description.rho = scenario.coupling.rho;
  description.alpha = scenario.coupling.alpha;
  description.method = MethodOf(scenario);
  Cooker cooker(scenario, workers, options);
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    if (scenario.pairs[i].owner != owner) continue;
    cooker.Require(scenario.pairs[i]);
    owned.scenario_pair.push_back(static_cast<std::uint16_t>(i));
    description.pairs.push_back(Describe(scenario, scenario.pairs[i]));
  }
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    auto data = cooker.Cook(i);
    if (!data) return core::Fail(data.error().code, data.error().detail);
    owned.data.push_back(*data);
    description.objects.push_back({*data, scenario.objects[i].X_WO});
  }
  auto world = vps::CollisionWorld::Create(description);
  if (!world) return core::Fail(world.error().code, world.error().detail);
  owned.world = std::move(*world);
  return owned;
}

bool FillContactUpdate(const vps::CollisionWorld& world, std::size_t pair, std::uint16_t scenario_pair,
                       int* empty_sets_left, core::ContactSet* set) {
  const vps::PairResult& result = world.result(pair);
  const bool is_near = world.is_active(pair) && (result.is_in_contact || !result.planes.empty());
  if (is_near) {
    if (!world.is_fresh(pair)) return false;  // late in this cycle: the last set sent still holds
    *empty_sets_left = kEmptySets;
  } else {
    if (*empty_sets_left == 0) return false;
    --*empty_sets_left;
  }
  set->header = {};
  world.FillContactSet(pair, set);
  set->pair_index = scenario_pair;
  if (!is_near) {
    set->is_in_contact = false;
    set->F_So_W = {};
    set->planes.clear();
  }
  return true;
}

}  // namespace collision
