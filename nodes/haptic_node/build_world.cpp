// Setup of HapticNode: cooks the objects that can collide, makes the collision world and the roles.

#include <algorithm>
#include <cstdio>
#include <map>
#include <tuple>

#include "nodes/haptic_node/haptic_node.hpp"
#include "vps/asset/cooked_object.hpp"

namespace haptic_node {

HapticNode::HapticNode(const scene::Scenario& scenario, core::ParallelFor& workers, const Options& options)
    : scenario_(scenario), workers_(workers), options_(options), force_cap_N_(scenario.force_cap_N) {}

core::Result<std::unique_ptr<HapticNode>> HapticNode::Create(const scene::Scenario& scenario,
                                                             core::ParallelFor& workers, const Options& options) {
  if (scenario.devices.size() > kMaxRoles) {
    return core::Fail(core::ErrorCode::kUnsupported, "scenario '" + scenario.name + "' has " +
                                                         std::to_string(scenario.devices.size()) +
                                                         " hand devices; at most " + std::to_string(kMaxRoles) +
                                                         " are supported: remove some <device>");
  }
  std::unique_ptr<HapticNode> node(new HapticNode(scenario, workers, options));
  if (const auto built = node->BuildWorld(); !built) return core::Fail(built.error().code, built.error().detail);
  node->BuildRoles();
  return node;
}

core::Result<std::vector<vps::ObjectDescription>> HapticNode::CookObjects() const {
  // Only what stands in a pair is built, and only the side that the pairs ask for (architecture D13).
  std::vector<std::uint8_t> is_sampled(scenario_.objects.size(), 0);
  std::vector<std::uint8_t> is_field(scenario_.objects.size(), 0);
  for (const scene::Pair& pair : scenario_.pairs) {
    is_sampled[pair.sampled] = 1;
    is_field[pair.field] = 1;
  }
  const vps::Method method = vps::MethodFromName(scenario_.method).value_or(vps::Method::kPaper);
  using Key = std::tuple<std::string, double, std::uint32_t, double>;
  std::map<Key, std::shared_ptr<const vps::CookedObject>> cooked;
  std::vector<vps::ObjectDescription> descriptions;
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    vps::ObjectDescription description;
    description.X_WO = object.X_WO;
    vps::CookParameters parameters;
    parameters.method = method;
    parameters.sheet_half_thickness_m = 0.5 * object.sheet_thickness_m;
    if (is_field[i] != 0) parameters.voxel_size_m = object.voxel_size_m;
    if (is_sampled[i] != 0) parameters.num_points = object.num_points;
    if (parameters.voxel_size_m > 0.0 || parameters.num_points > 0) {
      const Key key{object.collision_mesh.string(), parameters.voxel_size_m, parameters.num_points,
                    parameters.sheet_half_thickness_m};
      std::shared_ptr<const vps::CookedObject>& data = cooked[key];
      if (data == nullptr) {
        double told = -1.0;
        const auto progress = [&](std::string_view stage, double fraction) {
          // A line every tenth is enough for people.
          if (!options_.progress || (fraction < told + 0.1 && fraction >= told)) return;
          told = fraction;
          char line[160];
          std::snprintf(line, sizeof line, "cook %s: %.*s %3.0f %%", object.name.c_str(),
                        static_cast<int>(stage.size()), stage.data(), 100.0 * fraction);
          options_.progress(line);
        };
        auto result = vps::Cook(object.collision_mesh, parameters, options_.cache, progress, &workers_);
        if (!result) {
          return core::Fail(result.error().code, "object '" + object.name + "': " + result.error().detail);
        }
        data = std::make_shared<const vps::CookedObject>(std::move(*result));
      }
      description.data = data;
    }
    descriptions.push_back(description);
  }
  return descriptions;
}

core::Result<void> HapticNode::BuildWorld() {
  vps::WorldDescription description;
  auto objects = CookObjects();
  if (!objects) return core::Fail(objects.error().code, objects.error().detail);
  description.objects = std::move(*objects);
  description.rho = scenario_.coupling.rho;
  description.alpha = scenario_.coupling.alpha;
  description.method = vps::MethodFromName(scenario_.method).value_or(vps::Method::kPaper);
  for (std::size_t i = 0; i < scenario_.pairs.size(); ++i) {
    const scene::Pair& pair = scenario_.pairs[i];
    PairRole pair_role;
    pair_role.sampled_role = RoleOf(pair.sampled);
    pair_role.field_role = RoleOf(pair.field);
    const bool is_of_hand = pair_role.sampled_role >= 0 || pair_role.field_role >= 0;
    pair_role.is_published = pair_role.sampled_role < 0 || pair_role.field_role < 0;
    pair_roles_.push_back(pair_role);
    vps::PairDescription row;
    row.sampled = pair.sampled;
    row.field = pair.field;
    // physics_node evaluates a hand's planes at the device pose D. With k_f there it pushes the object by what the
    // spring from D to C makes the hand feel: action equals reaction.
    row.stiffness_N_per_m = is_of_hand ? scenario_.coupling.stiffness_N_per_m : pair.stiffness_N_per_m;
    row.damping_N_s_per_m = pair.damping_N_s_per_m;
    row.friction = pair.friction;
    row.look_ahead_m = pair.look_ahead_m;
    row.is_active = pair.is_active;
    description.pairs.push_back(row);
    pair_active_names_.push_back("pair." + scenario_.PairName(i) + ".active");
    pair_stiffness_names_.push_back("pair." + scenario_.PairName(i) + ".stiffness_N_per_m");
  }
  for (const scene::Object& object : scenario_.objects) X_WO_.push_back(object.X_WO);
  auto world = vps::CollisionWorld::Create(description);
  if (!world) return core::Fail(world.error().code, world.error().detail);
  world_ = std::move(*world);

  roles_.resize(scenario_.devices.size());
  for (std::size_t r = 0; r < roles_.size(); ++r) {
    Role& role = roles_[r];
    role.device = scenario_.devices[r];
    role.is_hand_part.assign(scenario_.objects.size(), 0);
    // All points of the hand lie within this radius about the palm's origin, whatever the opening.
    double radius_m = 0.0;
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      const scene::Object& object = scenario_.objects[i];
      if (object.owner != scene::Owner::kHand || object.role != static_cast<int>(r)) continue;
      role.is_hand_part[i] = 1;
      const vps::CookedObject* data = description.objects[i].data.get();
      if (data == nullptr) continue;
      const double shift_m = object.part == scene::HandPart::kPalm ? 0.0 : 0.5 * role.device.opening_max_m;
      radius_m = std::max(radius_m, glm::length(data->bounding_centre_m) + data->bounding_radius_m + shift_m);
    }
    vps::CouplingParameters parameters;
    parameters.stiffness_N_per_m = scenario_.coupling.stiffness_N_per_m;
    parameters.stiffness_Nm_per_rad = scenario_.coupling.stiffness_Nm_per_rad;
    parameters.eta = scenario_.coupling.eta;
    parameters.sigma_m2 = scenario_.coupling.sigma_m2;
    parameters.rest_penetration_m = world_->RestPenetration(role.is_hand_part);
    if (radius_m > 0.0) parameters.bounding_radius_m = radius_m;
    role.coupling = vps::VirtualCoupling(parameters);
  }
  return {};
}

void HapticNode::BuildRoles() {
  for (Role& role : roles_) {
    role.sample.X_WD = role.device.X_WD_start;
    role.sample.opening_m = role.device.opening_start_m;
    role.coupling.Reset(role.device.X_WD_start);
  }
}

int HapticNode::RoleOf(std::uint16_t object) const {
  const scene::Object& o = scenario_.objects[object];
  return o.owner == scene::Owner::kHand ? o.role : -1;
}

void HapticNode::PrepareOutputs(Outputs* outputs) const {
  outputs->contacts.assign(scenario_.pairs.size(), core::ContactSet{});
  outputs->contacts_updated.assign(scenario_.pairs.size(), 0);
}

}  // namespace haptic_node
