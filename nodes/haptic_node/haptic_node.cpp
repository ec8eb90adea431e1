#include "nodes/haptic_node/haptic_node.hpp"

#include <algorithm>

#include "core/clock.hpp"

namespace haptic_node {
namespace {

// Of the budget of time: the rest is for what does not grow with the points, and for the machine's moods.
constexpr double kShareForPoints = 0.75;
constexpr std::int64_t kEver_ns = 3600'000'000'000;
constexpr double kFewPoints = 2048;  // fewer say nothing about what one takes
constexpr double kPointTimeGain = 0.02;
constexpr double kMostDelay_cycles = 100.0;
constexpr double kDelayFade = 0.999;  // a cycle: a delay is remembered for about a second
constexpr double kFadeIn_ns = 5.0 * static_cast<double>(kFade_ns);

double Approach(double gain, bool is_trusted, std::int64_t elapsed_ns) {
  const auto elapsed = static_cast<double>(elapsed_ns);
  const double next = is_trusted ? gain + elapsed / kFadeIn_ns : gain - elapsed / static_cast<double>(kFade_ns);
  return std::clamp(next, 0.0, 1.0);
}

// Scaled so that the force is not above the cap; the torque with it, so the line along which it acts stays.
core::Wrench Cap(const core::Wrench& F, double cap_N) {
  const double force_N = glm::length(F.force_N);
  return force_N > cap_N ? (cap_N / force_N) * F : F;
}

// Direction of the penalty force on S in W; zero without contact.
glm::dvec3 PushOnSampled_W(const vps::PairResult& result, const core::Pose& X_WS) {
  const double length = glm::length(result.f_So_S.sum_m);
  if (!result.is_in_contact || length <= 0.0) return glm::dvec3(0.0);
  return X_WS.rotate(result.f_So_S.sum_m / length);
}

}  // namespace

std::vector<std::string> HapticNode::ParameterNames() const {
  std::vector<std::string> names = {"force_cap_N"};
  names.insert(names.end(), pair_active_names_.begin(), pair_active_names_.end());
  for (const std::string& name : pair_stiffness_names_) {
    if (AcceptsParameter({name, 0.0})) names.push_back(name);
  }
  return names;
}

bool HapticNode::AcceptsParameter(const core::ParameterChange& change) const {
  if (change.manner != core::ChangeManner::kAtOnce) return false;
  if (change.name == "force_cap_N") return change.value >= 0.0;
  for (std::size_t i = 0; i < pair_active_names_.size(); ++i) {
    if (change.name == pair_active_names_[i]) return true;
    // A hand's pair has the stiffness of the coupling.
    if (change.name == pair_stiffness_names_[i]) {
      return change.value >= 0.0 && pair_roles_[i].sampled_role < 0 && pair_roles_[i].field_role < 0;
    }
  }
  return false;
}

void HapticNode::ApplyChange(const core::ParameterChange& change) {
  if (!AcceptsParameter(change)) return;
  if (change.name == "force_cap_N") force_cap_N_ = change.value;
  for (std::size_t i = 0; i < pair_active_names_.size(); ++i) {
    if (change.name == pair_active_names_[i]) world_->SetActive(i, change.value != 0.0);
    if (change.name == pair_stiffness_names_[i]) world_->SetStiffness(i, change.value);
  }
}

void HapticNode::Step(const Inputs& inputs, Outputs* outputs) noexcept {
  ++cycle_;
  for (std::size_t i = 0; i < inputs.num_changes; ++i) ApplyChange(inputs.changes[i]);
  TakeDevices(inputs);
  TakePhysics(inputs);
  PlaceObjects();
  const vps::StepReport& report = StepWorld(inputs.budget_points, &outputs->counters);
  for (Role& role : roles_) StepCoupling(&role);

  outputs->commands.clear();
  outputs->proxies.clear();
  for (std::size_t r = 0; r < roles_.size(); ++r) FillRoleOutputs(r, inputs, outputs);
  FillContacts(inputs, outputs);
  outputs->is_in_contact = report.pairs_in_contact > 0;
  Counters& counters = outputs->counters;
  counters.pairs_considered = report.pairs_considered;
  counters.pairs_inactive = report.pairs_inactive;
  counters.pairs_coherent = report.pairs_coherent + report.pairs_bounded + report.pairs_unchanged;
  counters.pairs_tested = report.pairs_tested;
  counters.pairs_in_contact = report.pairs_in_contact;
  counters.pairs_cut_short = report.pairs_cut_short;
  counters.pairs_late = report.pairs_late;
  counters.oldest_result_cycles = report.oldest_result_cycles;
  counters.spheres_tested = report.counters.spheres_tested;
  counters.points_tested = report.counters.points_tested;
  counters.points_colliding = report.counters.points_colliding;
  last_step_ns_ = inputs.now_ns;
}

// With a budget of time, heavy pairs are cut short rather than late: the points that fit into it go first to where the
// contact is deepest. What a point takes, with its share of everything else, is measured as the node runs.
const vps::StepReport& HapticNode::StepWorld(std::uint64_t budget_points, Counters* counters) {
  counters->budget_points = budget_points;
  // Repeated: the same points, in the order that a budget of time makes, however long it takes.
  if (budget_points != 0) return world_->Step(&workers_, kEver_ns, budget_points);
  if (options_.budget_ns == 0) return world_->Step(&workers_);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  counters->budget_points =
      static_cast<std::uint64_t>(kShareForPoints * static_cast<double>(options_.budget_ns) / point_time_ns_);
  const vps::StepReport& report = world_->Step(&workers_, options_.budget_ns, counters->budget_points);
  const auto num_points = static_cast<double>(report.counters.points_tested);
  if (num_points < kFewPoints) return report;
  const double point_time_ns = static_cast<double>(core::MonotonicNow_ns() - begin_ns) / num_points;
  point_time_ns_ += kPointTimeGain * (std::clamp(point_time_ns, 1.0, 100.0) - point_time_ns_);
  return report;
}

void HapticNode::TakeDevices(const Inputs& inputs) {
  for (const core::DeviceState& device : inputs.devices) {
    if (device.header.sequence == 0 || device.role_index >= roles_.size()) continue;
    Role& role = roles_[device.role_index];
    role.device_freshness.Note(device.header.sequence, inputs.now_ns);
    role.sample = device;
  }
  for (Role& role : roles_) {
    const bool is_held = role.device_freshness.has_arrived() && role.sample.is_engaged &&
                         !role.device_freshness.is_stale(inputs.now_ns, kDeviceStale_ns);
    if (!is_held || !role.is_following) role.coupling.Reset(role.sample.X_WD);
    role.is_following = is_held;
  }
}

void HapticNode::TakePhysics(const Inputs& inputs) {
  const std::int64_t elapsed_ns = cycle_ == 1 ? 0 : std::max<std::int64_t>(inputs.now_ns - last_step_ns_, 0);
  if (inputs.physics != nullptr && inputs.physics->header.sequence != 0) {
    physics_freshness_.Note(inputs.physics->header.sequence, inputs.now_ns);
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object < X_WO_.size()) X_WO_[body.object] = body.X_WO;
    }
    NoteDelay(inputs.physics->header.direct);
  }
  // Objects whose owner is silent are not where they seem to be: neither contact with them nor a grasp may push on.
  const bool is_silent =
      physics_freshness_.has_arrived() && physics_freshness_.is_stale(inputs.now_ns, kPhysicsStale_ns);
  physics_gain_ = Approach(physics_gain_, !is_silent, elapsed_ns);

  for (const core::Reaction& reaction : inputs.reactions) {
    if (reaction.header.sequence == 0 || reaction.role_index >= roles_.size()) continue;
    Role& role = roles_[reaction.role_index];
    role.reaction_freshness.Note(reaction.header.sequence, inputs.now_ns);
    role.reaction = reaction;
  }
  for (Role& role : roles_) {
    const bool is_trusted =
        role.reaction_freshness.has_arrived() && !role.reaction_freshness.is_stale(inputs.now_ns, kPhysicsStale_ns);
    // A reaction is trusted from its first message on: fading in would tear at what is held.
    role.reaction_gain = is_trusted ? 1.0 : Approach(role.reaction_gain, false, elapsed_ns);
  }
}

// A device sample's way through physics and back is longer than that of planes, from a body's pose to their use. Both
// ends are read off the device's clock.
void HapticNode::NoteDelay(const core::Trace& sample) {
  std::int64_t newest_ns = 0;
  for (const Role& role : roles_) newest_ns = std::max(newest_ns, role.sample.header.direct.origin_ns);
  if (!sample.valid() || newest_ns == 0) return;
  const double cycles = static_cast<double>(newest_ns - sample.origin_ns) / static_cast<double>(core::kTick_ns);
  delay_cycles_ = std::max(std::clamp(cycles, 0.0, kMostDelay_cycles), kDelayFade * delay_cycles_);
  world_->SetDelay(delay_cycles_);
}

void HapticNode::PlaceObjects() {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner == scene::Owner::kHand && object.role >= 0) {
      const Role& role = roles_[static_cast<std::size_t>(object.role)];
      X_WO_[i] = scene::PartPose(object.part, role.coupling.X_WC(), role.sample.opening_m);
    }
    world_->SetPose(i, X_WO_[i]);
  }
}

int HapticNode::IgnoredObject(const Role& role) const {
  return role.reaction_gain > 0.0 && role.reaction.grasped_object != core::kNoObject
             ? static_cast<int>(role.reaction.grasped_object)
             : -1;
}

bool HapticNode::IsHeld(const PairRole& pair_role, std::size_t pair) const {
  const scene::Pair& p = PairOf(pair);
  if (pair_role.sampled_role >= 0) {
    return IgnoredObject(roles_[static_cast<std::size_t>(pair_role.sampled_role)]) == p.field;
  }
  return pair_role.field_role >= 0 &&
         IgnoredObject(roles_[static_cast<std::size_t>(pair_role.field_role)]) == p.sampled;
}

void HapticNode::StepCoupling(Role* role) {
  role->F_Do_W = {};
  role->sum_of_weights_m = 0.0;
  if (!role->is_following) return;
  world_->HandContact(role->is_hand_part, role->coupling.X_WC(), &role->contact, IgnoredObject(*role));
  role->F_Do_W = role->coupling.Step(role->sample.X_WD, role->contact);
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    const scene::Pair& pair = PairOf(i);
    if (role->is_hand_part[pair.sampled] == role->is_hand_part[pair.field] || IsHeld(pair_roles_[i], i)) continue;
    if (!world_->is_active(i) || !world_->result(i).is_in_contact) continue;
    role->sum_of_weights_m += glm::length(world_->result(i).f_So_S.sum_m);
  }
}

// Force that opens the jaws, on the gripper's one axis. Virtual work: when the opening w grows by dw, each jaw moves by
// dw/2 outwards, so normal forces N_l and N_r on the jaws do the work (N_l + N_r) dw/2.
// N = jaw_stiffness * penetration, of which the part along the axis counts.
double HapticNode::JawForce_N(std::size_t role_index) const {
  const Role& role = roles_[role_index];
  if (!role.is_following) return 0.0;
  const glm::dvec3 axis_W = role.coupling.X_WC().rotate(glm::dvec3(1.0, 0.0, 0.0));
  double sum_N = 0.0;
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    const scene::Pair& pair = PairOf(i);
    const vps::PairResult& result = world_->result(i);
    if (!world_->is_active(i) || !result.is_in_contact) continue;
    for (const bool is_sampled : {true, false}) {
      const std::uint16_t part = is_sampled ? pair.sampled : pair.field;
      const bool is_left = static_cast<int>(part) == role.device.jaw_left;
      if (!is_left && static_cast<int>(part) != role.device.jaw_right) continue;
      const glm::dvec3 push_W = (is_sampled ? 1.0 : -1.0) * PushOnSampled_W(result, X_WO_[pair.sampled]);
      const double outwards = (is_left ? -1.0 : 1.0) * glm::dot(push_W, axis_W);
      sum_N +=
          scenario_.coupling.jaw_stiffness_N_per_m * std::max(-result.signed_distance_m, 0.0) * std::max(outwards, 0.0);
    }
  }
  return 0.5 * sum_N;
}

void HapticNode::FillRoleOutputs(std::size_t role_index, const Inputs& inputs, Outputs* outputs) {
  Role& role = roles_[role_index];
  core::Trace through_physics;
  const core::Trace* newest = role.reaction.header.through_physics.valid() ? &role.reaction.header.through_physics
                              : inputs.physics != nullptr                  ? &inputs.physics->header.through_physics
                                                                           : nullptr;
  // Once per sample: the chain closes with the first command that holds its effect.
  if (newest != nullptr && newest->valid() && newest->id != role.last_trace_through_physics) {
    through_physics = *newest;
    role.last_trace_through_physics = newest->id;
  }

  core::DeviceCommand command;
  command.header.direct = role.sample.header.direct;
  command.header.through_physics = through_physics;
  command.role_index = static_cast<std::uint8_t>(role_index);
  if (role.is_following) {
    const core::Wrench F = role.F_Do_W + role.reaction_gain * role.reaction.F_Do_W;
    command.F_Do_W = physics_gain_ * Cap(F, force_cap_N_);
    command.grip_force_N = physics_gain_ * JawForce_N(role_index);
  }
  outputs->commands.push_back(command);

  core::HapticProxy proxy;
  proxy.header = command.header;
  proxy.role_index = command.role_index;
  proxy.cycle = cycle_;
  proxy.X_WD = role.sample.X_WD;
  proxy.V_WD = role.sample.V_WD;
  proxy.X_WC = role.coupling.X_WC();
  proxy.opening_m = role.sample.opening_m;
  proxy.is_in_contact = role.is_following && role.contact.is_in_contact;
  proxy.is_engaged = role.is_following;
  proxy.F_Do_W = role.F_Do_W;
  outputs->proxies.push_back(proxy);
}

void HapticNode::FillContacts(const Inputs& inputs, Outputs* outputs) {
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    PairRole& pair_role = pair_roles_[i];
    const std::uint16_t slot = pair_role.scenario_pair;
    core::ContactSet& set = outputs->contacts[slot];
    outputs->contacts_updated[slot] = 0;
    if (!pair_role.is_published) continue;
    if (!collision::TellContact(*world_, i, slot, &pair_role.empty_sets_left, &set)) continue;
    set.cycle = cycle_;
    if (inputs.physics != nullptr) set.header.through_physics = inputs.physics->header.through_physics;
    ShareHandContact(i, pair_role, &set);
    outputs->contacts_updated[slot] = 1;
  }
}

// What the coupling makes the hand feel is shared among the pairs that made it, in proportion to their penetration
// sums: together the objects get the opposite of the hand's force, not a multiple of it.
void HapticNode::ShareHandContact(std::size_t pair, const PairRole& pair_role, core::ContactSet* set) const {
  const int role_index = std::max(pair_role.sampled_role, pair_role.field_role);
  if (role_index < 0) return;
  const Role& role = roles_[static_cast<std::size_t>(role_index)];
  set->header.direct = role.sample.header.direct;
  set->F_So_W = {};
  if (!set->is_in_contact || role.sum_of_weights_m <= 0.0 || IsHeld(pair_role, pair)) return;
  const double share = glm::length(world_->result(pair).f_So_S.sum_m) / role.sum_of_weights_m;
  const bool is_hand_sampled = pair_role.sampled_role >= 0;
  const glm::dvec3 p_SoDo_W = role.sample.X_WD.translation - X_WO_[set->sampled_body].translation;
  set->F_So_W = core::ShiftWrench((is_hand_sampled ? share : -share) * role.F_Do_W, p_SoDo_W);
  for (core::ContactPlane& plane : set->planes) plane.stiffness_N_per_m *= static_cast<float>(share);
}

}  // namespace haptic_node
