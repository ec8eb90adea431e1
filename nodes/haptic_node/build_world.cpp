// Setup of HapticNode: the collision world of its pairs, and its roles.

#include <algorithm>

#include "core/hand_limits.hpp"
#include "nodes/haptic_node/describe_tool.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "scene/has_fingers.hpp"
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
  return node;
}

core::Result<void> HapticNode::BuildWorld() {
  auto owned = collision::BuildOwnedWorld(scenario_, scene::PairOwner::kHaptic, workers_, options_.collision);
  if (!owned) return core::Fail(owned.error().code, owned.error().detail);
  world_ = std::move(owned->world);
  for (const scene::Object& object : scenario_.objects) X_WO_.push_back(object.X_WO);
  V_WO_.resize(X_WO_.size());
  moved_X_WO_ = X_WO_;
  moved_V_WO_ = V_WO_;
  BuildPairRoles(owned->scenario_pair);
  BuildRoles(*owned);
  return {};
}

void HapticNode::BuildPairRoles(const std::vector<std::uint16_t>& scenario_pairs) {
  for (const std::uint16_t i : scenario_pairs) {
    const scene::Pair& pair = scenario_.pairs[i];
    PairRole pair_role;
    pair_role.scenario_pair = i;
    pair_role.sampled_role = RoleOf(pair.sampled);
    pair_role.field_role = RoleOf(pair.field);
    pair_role.is_published = pair_role.sampled_role < 0 || pair_role.field_role < 0;
    pair_roles_.push_back(pair_role);
    pair_active_names_.push_back("pair." + scenario_.PairName(i) + ".active");
    pair_stiffness_names_.push_back("pair." + scenario_.PairName(i) + ".stiffness_N_per_m");
  }
}

void HapticNode::BuildRoles(const collision::OwnedWorld& owned) {
  roles_.resize(scenario_.devices.size());
  for (std::size_t r = 0; r < roles_.size(); ++r) {
    Role& role = roles_[r];
    role.device = scenario_.devices[r];
    role.has_fingers = scene::HasFingers(scenario_, static_cast<int>(r));
    stiffness_limit_names_.push_back(core::StiffnessLimitName(role.device.role));
    damping_limit_names_.emplace_back();
    turn_damping_limit_names_.emplace_back();
    role.is_hand_part.assign(scenario_.objects.size(), 0);
    // Radius about the palm's origin that contains all points of the hand for any opening: r = max(|c| + r_c + w_max /
    // 2) over its parts with bounding sphere (c, r_c); the term of the opening w applies to jaws only.
    double radius_m = 0.0;
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      const scene::Object& object = scenario_.objects[i];
      if (object.owner != scene::Owner::kHand || object.role != static_cast<int>(r)) continue;
      role.is_hand_part[i] = 1;
      const vps::CookedObject* data = owned.data[i].get();
      if (data == nullptr) continue;
      const double shift_m = object.part == scene::HandPart::kPalm ? 0.0 : 0.5 * role.device.opening_max_m;
      radius_m = std::max(radius_m, glm::length(data->bounding_centre_m) + data->bounding_radius_m + shift_m);
    }
    vps::CouplingParameters parameters;
    parameters.stiffness_N_per_m = scenario_.coupling.stiffness_N_per_m;
    parameters.stiffness_Nm_per_rad = scenario_.coupling.stiffness_Nm_per_rad;
    parameters.eta = scenario_.coupling.eta;
    parameters.sigma_m2 = scenario_.coupling.sigma_m2;
    if (radius_m > 0.0) parameters.bounding_radius_m = radius_m;
    role.coupling = vps::VirtualCoupling(parameters);
    role.sample.X_WD = role.device.X_WD_start;
    role.sample.opening_m = role.device.opening_start_m;
    if (scenario_.coupling.type == "god_object") role.god_object.emplace(DescribeTool(scenario_, r, radius_m));
    if (role.god_object && role.god_object->parameters().mass_kg > 0.0) {
      damping_limit_names_[r] = core::DampingLimitName(role.device.role);
      turn_damping_limit_names_[r] = core::TurnDampingLimitName(role.device.role);
    }
    role.Reset(role.device.X_WD_start);
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
