#include "nodes/haptic_node/haptic_node.hpp"

#include <algorithm>
#include <iterator>

#include "collision/collision_matrix.hpp"
#include "core/clock.hpp"
#include "nodes/haptic_node/contact_field.hpp"

namespace haptic_node {
namespace {

// These values are chosen, not derived. A larger share for points uses more of the budget and is late more often;
// larger gains follow a change of the machine's speed sooner and are noisier.
constexpr double kShareForPoints = 0.75;  // of the time budget; the rest is for work that does not grow with the points
constexpr std::int64_t kUnlimited_ns = 3600'000'000'000;
constexpr double kMinPointsToMeasure = 2048;  // with fewer, the fixed costs dominate the time per point
constexpr double kPointTimeGain = 0.02;       // of the moving average of the time per point
constexpr double kMaxDelay_cycles = 100.0;
constexpr std::uint64_t kCollisionsPeriod_cycles = 16;  // of the collision matrix: 62/s, more than viewers draw
constexpr double kDelayDecay = 0.999;       // per cycle: the largest delay decays with a time constant of 1 s
constexpr double kMaxPlaneStiffness = 4.0;  // of a plane in contact with a hand, relative to the coupling's
constexpr double kShareRate_per_s = 4.0;    // of a hand's stiffness towards its limit
constexpr double kFadeIn_ns = 5.0 * static_cast<double>(kFade_ns);

// Linear fade of a gain: up to 1 within kFadeIn while its source is trusted, down to 0 within kFade otherwise.
double FadeGain(double gain, bool is_trusted, std::int64_t elapsed_ns) {
  const auto elapsed = static_cast<double>(elapsed_ns);
  const double next = is_trusted ? gain + elapsed / kFadeIn_ns : gain - elapsed / static_cast<double>(kFade_ns);
  return std::clamp(next, 0.0, 1.0);
}

// The newest message of a role that `inputs` has; else the one that the node has.
template <class List, class Message>
const Message& NewestOf(const List& messages, std::size_t role_index, const Message& known) {
  for (const Message& message : messages) {
    if (message.header.sequence != 0 && message.role_index == role_index) return message;
  }
  return known;
}

// Unit direction of the penalty force on S, in W; zero without contact.
glm::dvec3 ForceDirectionOnSampled_W(const vps::PairResult& result, const core::Pose& X_WS) {
  const double length = glm::length(result.f_So_S.sum_m);
  if (!result.is_in_contact || length <= 0.0) return glm::dvec3(0.0);
  return X_WS.rotate(result.f_So_S.sum_m / length);
}

// Moves q_G along its plane to where p_S has slipped from by `slip_W`.
void StickAt(const core::Pose& X_WS, const core::Pose& X_WG, const glm::dvec3& slip_W, core::ContactPlane* plane) {
  const glm::dvec3 p_W = X_WS * glm::dvec3(plane->p_S);
  const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane->n_G));
  const double gap_m = glm::dot(n_W, p_W - X_WG * glm::dvec3(plane->q_G));
  plane->q_G = glm::vec3(X_WG.inverse() * (p_W - gap_m * n_W - slip_W));
}

}  // namespace

std::vector<std::string> HapticNode::ParameterNames() const {
  std::vector<std::string> names = {"force_cap_N"};
  names.insert(names.end(), stiffness_limit_names_.begin(), stiffness_limit_names_.end());
  for (const auto* limits : {&damping_limit_names_, &turn_damping_limit_names_}) {
    std::copy_if(limits->begin(), limits->end(), std::back_inserter(names),
                 [](const std::string& name) { return !name.empty(); });
  }
  names.insert(names.end(), pair_active_names_.begin(), pair_active_names_.end());
  for (const std::string& name : pair_stiffness_names_) {
    if (AcceptsParameter({name, 0.0})) names.push_back(name);
  }
  return names;
}

bool HapticNode::AcceptsParameter(const core::ParameterChange& change) const {
  if (change.manner != core::ChangeManner::kAtOnce) return false;
  if (change.name == "force_cap_N") return change.value >= 0.0;
  for (const std::string& name : stiffness_limit_names_) {
    if (change.name == name) return change.value >= 0.0;
  }
  if (IsDampingLimit(change.name)) return change.value >= 0.0;
  for (std::size_t i = 0; i < pair_active_names_.size(); ++i) {
    if (change.name == pair_active_names_[i]) return true;
    // The stiffness of a hand's pair is that of the coupling, so it cannot be set.
    if (change.name == pair_stiffness_names_[i]) {
      return change.value >= 0.0 && pair_roles_[i].sampled_role < 0 && pair_roles_[i].field_role < 0;
    }
  }
  return false;
}

void HapticNode::ApplyChange(const core::ParameterChange& change) {
  if (!AcceptsParameter(change)) return;
  if (change.name == "force_cap_N") force_cap_N_ = change.value;
  for (std::size_t r = 0; r < roles_.size(); ++r) {
    if (change.name == stiffness_limit_names_[r]) roles_[r].stiffness_limit = std::min(change.value, 1.0);
  }
  if (IsDampingLimit(change.name)) LimitDamping(change);
  for (std::size_t i = 0; i < pair_active_names_.size(); ++i) {
    if (change.name == pair_active_names_[i]) world_->SetActive(i, change.value != 0.0);
    if (change.name == pair_stiffness_names_[i]) world_->SetStiffness(i, change.value);
  }
}

void HapticNode::Step(const Inputs& inputs, Outputs* outputs) noexcept {
  ++cycle_;
  for (std::size_t i = 0; i < inputs.num_changes; ++i) ApplyChange(inputs.changes[i]);
  UpdateDevices(inputs);
  UpdatePhysics(inputs);
  PlaceObjects();
  const vps::StepReport& report = StepWorld(inputs.budget_points, &outputs->counters);
  const std::int64_t elapsed_ns = std::clamp<std::int64_t>(inputs.now_ns - last_step_ns_, 0, core::kTick_ns);
  for (Role& role : roles_) {
    LimitStiffness(&role, elapsed_ns);
    StepCoupling(&role);
  }

  outputs->commands.clear();
  outputs->proxies.clear();
  for (std::size_t r = 0; r < roles_.size(); ++r) FillRoleOutputs(r, inputs, outputs);
  FillContacts(inputs, outputs);
  FillCollisions(outputs);
  // A god object rests on a surface, not in it.
  outputs->is_in_contact = report.pairs_in_contact > 0 ||
                           std::any_of(roles_.begin(), roles_.end(), [](const Role& r) { return r.is_in_contact; });
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

// With a time budget T, pairs with many points are tested in part rather than late, the deepest places first. The
// number of points is n = share T / t_p, with the time per point t_p (including all other work) measured at run time as
// a moving average.
const vps::StepReport& HapticNode::StepWorld(std::uint64_t budget_points, Counters* counters) {
  counters->budget_points = budget_points;
  // Replay: the same points in the same order as with the recorded budget, without a time limit.
  if (budget_points != 0) return world_->Step(&workers_, kUnlimited_ns, budget_points);
  if (options_.budget_ns == 0) return world_->Step(&workers_);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  counters->budget_points =
      static_cast<std::uint64_t>(kShareForPoints * static_cast<double>(options_.budget_ns) / point_time_ns_);
  const vps::StepReport& report = world_->Step(&workers_, options_.budget_ns, counters->budget_points);
  const auto num_points = static_cast<double>(report.counters.points_tested);
  if (num_points < kMinPointsToMeasure) return report;
  const double point_time_ns = static_cast<double>(core::MonotonicNow_ns() - begin_ns) / num_points;
  point_time_ns_ += kPointTimeGain * (std::clamp(point_time_ns, 1.0, 100.0) - point_time_ns_);
  return report;
}

void HapticNode::UpdateDevices(const Inputs& inputs) {
  for (const core::DeviceState& device : inputs.devices) {
    if (device.header.sequence == 0 || device.role_index >= roles_.size()) continue;
    Role& role = roles_[device.role_index];
    role.device_freshness.Update(device.header.sequence, inputs.now_ns);
    role.sample = device;
  }
  for (Role& role : roles_) {
    const bool is_held = role.device_freshness.has_arrived() && role.sample.is_engaged &&
                         !role.device_freshness.is_stale(inputs.now_ns, kDeviceStale_ns);
    if (!is_held || !role.is_following) role.Reset(role.sample.X_WD);
    role.is_following = is_held;
  }
}

void HapticNode::UpdatePhysics(const Inputs& inputs) {
  const std::int64_t elapsed_ns = cycle_ == 1 ? 0 : std::max<std::int64_t>(inputs.now_ns - last_step_ns_, 0);
  if (inputs.physics != nullptr && inputs.physics->header.sequence != 0) {
    physics_freshness_.Update(inputs.physics->header.sequence, inputs.now_ns);
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object >= X_WO_.size()) continue;
      X_WO_[body.object] = body.X_WO;
      V_WO_[body.object] = body.V_WO;
    }
    UpdateDelay(inputs.physics->header.direct);
  }
  // While physics_node is silent the poses of its objects are outdated, so neither contacts nor grasps may exert
  // forces.
  const bool is_silent =
      physics_freshness_.has_arrived() && physics_freshness_.is_stale(inputs.now_ns, kPhysicsStale_ns);
  physics_gain_ = FadeGain(physics_gain_, !is_silent, elapsed_ns);

  for (const core::Reaction& reaction : inputs.reactions) {
    if (reaction.header.sequence == 0 || reaction.role_index >= roles_.size()) continue;
    Role& role = roles_[reaction.role_index];
    role.reaction_freshness.Update(reaction.header.sequence, inputs.now_ns);
    role.reaction = reaction;
  }
  for (Role& role : roles_) {
    const bool is_trusted =
        role.reaction_freshness.has_arrived() && !role.reaction_freshness.is_stale(inputs.now_ns, kPhysicsStale_ns);
    // A reaction acts in full from its first message on: while it faded in, hand and held object would separate.
    role.reaction_gain = is_trusted ? 1.0 : FadeGain(role.reaction_gain, false, elapsed_ns);
  }
}

// Upper bound of the delay from a body's pose to the use of planes computed from it: the round trip of a device sample
// through physics, both ends taken from the device's clock. d <- max(d_measured, 0.999 d).
void HapticNode::UpdateDelay(const core::Trace& sample) {
  std::int64_t newest_ns = 0;
  for (const Role& role : roles_) newest_ns = std::max(newest_ns, role.sample.header.direct.origin_ns);
  if (!sample.valid() || newest_ns == 0) return;
  const double cycles = static_cast<double>(newest_ns - sample.origin_ns) / static_cast<double>(core::kTick_ns);
  delay_cycles_ = std::max(std::clamp(cycles, 0.0, kMaxDelay_cycles), kDelayDecay * delay_cycles_);
  world_->SetDelay(delay_cycles_);
}

void HapticNode::PlaceObjects() {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner == scene::Owner::kHand && object.role >= 0) {
      const Role& role = roles_[static_cast<std::size_t>(object.role)];
      X_WO_[i] = scene::PartPose(object.part, role.X_WC(), role.sample.opening_m);
    }
    world_->SetPose(i, X_WO_[i]);
  }
}

int HapticNode::IgnoredObject(const core::Reaction& reaction, double gain) {
  return gain > 0.0 && reaction.grasped_object != core::kNoObject ? static_cast<int>(reaction.grasped_object) : -1;
}

bool HapticNode::IsHeld(const PairRole& pair_role, std::size_t pair) const {
  const scene::Pair& p = PairOf(pair);
  if (pair_role.sampled_role >= 0) {
    return IgnoredObject(roles_[static_cast<std::size_t>(pair_role.sampled_role)]) == p.field;
  }
  return pair_role.field_role >= 0 &&
         IgnoredObject(roles_[static_cast<std::size_t>(pair_role.field_role)]) == p.sampled;
}

double HapticNode::stiffness_share() const {
  double least = 1.0;
  for (const Role& role : roles_) least = std::min(least, role.stiffness_share);
  return least;
}

bool HapticNode::IsDampingLimit(const std::string& name) const {
  const auto is_in = [&name](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return !name.empty() && (is_in(damping_limit_names_) || is_in(turn_damping_limit_names_));
}

void HapticNode::LimitDamping(const core::ParameterChange& change) {
  for (std::size_t r = 0; r < roles_.size(); ++r) {
    if (!roles_[r].god_object) continue;
    const vps::GodObjectParameters& now = roles_[r].god_object->parameters();
    if (change.name == damping_limit_names_[r]) {
      roles_[r].god_object->LimitDamping(change.value, now.most_damping_Nm_s_per_rad);
    } else if (change.name == turn_damping_limit_names_[r]) {
      roles_[r].god_object->LimitDamping(now.most_damping_N_s_per_m, change.value);
    }
  }
}

// The stiffness follows its limit so slowly that a pressing hand feels no step: 24 N change by 0.1 N in a cycle.
void HapticNode::LimitStiffness(Role* role, std::int64_t elapsed_ns) {
  if (role->stiffness_share == role->stiffness_limit) return;
  const double most = kShareRate_per_s * 1e-9 * static_cast<double>(elapsed_ns);
  role->stiffness_share += std::clamp(role->stiffness_limit - role->stiffness_share, -most, most);
  least_stiffness_share_ = std::min(least_stiffness_share_, role->stiffness_share);
  const double k = role->stiffness_share * scenario_.coupling.stiffness_N_per_m;
  const double k_t = role->stiffness_share * scenario_.coupling.stiffness_Nm_per_rad;
  vps::CouplingParameters parameters = role->coupling.parameters();
  parameters.stiffness_N_per_m = k;
  parameters.stiffness_Nm_per_rad = k_t;
  role->coupling.set_parameters(parameters);
  if (role->god_object) role->god_object->SetStiffness(k, k_t);
}

// With the share of the last cycle that had a force: what is rendered late of a contact that is over is the objects',
// too.
void HapticNode::KeepBooks(Role* role) const {
  const double square_N2 = glm::dot(role->F_Do_W.force_N, role->F_Do_W.force_N);
  if (square_N2 > 0.0) {
    role->objects_share = std::clamp(glm::dot(role->objects_N, role->F_Do_W.force_N) / square_N2, 0.0, 1.0);
  }
  role->books.Update(role->sample.J_contact_Wo_W.force_N, role->reaction.J_contact_Wo_W.force_N, role->objects_share);
}

void HapticNode::StepCoupling(Role* role) {
  KeepBooks(role);
  role->F_Do_W = {};
  role->objects_N = glm::dvec3(0.0);
  role->sum_of_weights_m = 0.0;
  role->is_in_contact = false;
  if (!role->is_following) return;
  if (role->god_object) {
    world_->HandPlanes(role->is_hand_part, &role->tool_contact, IgnoredObject(*role));
    role->F_Do_W = role->god_object->Step(role->sample.X_WD, role->tool_contact, X_WO_);
    double strongest_N = 0.0;
    for (const vps::HeldContact& contact : role->god_object->contacts()) {
      role->is_in_contact = role->is_in_contact || contact.normal_N > 0.0;
      if (contact.normal_N > 0.0) world_->KeepHandPlane(contact.id);
      if (scenario_.objects[contact.body].owner != scene::Owner::kPhysics || !(contact.normal_N > 0.0)) continue;
      role->objects_N += contact.normal_N * contact.n_W + contact.tangent_W_N;
      if (contact.normal_N <= strongest_N) continue;
      strongest_N = contact.normal_N;
      role->owing_pair = vps::CollisionWorld::PairOfHandPlane(contact.id);
      role->owing_object = contact.body;
      role->p_O_owing = X_WO_[contact.body].inverse() * contact.p_W;
    }
    return;
  }
  world_->HandContact(role->is_hand_part, role->coupling.X_WC(), &role->contact, IgnoredObject(*role));
  role->F_Do_W = role->coupling.Step(role->sample.X_WD, role->contact);
  role->is_in_contact = role->contact.is_in_contact;
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    const scene::Pair& pair = PairOf(i);
    if (role->is_hand_part[pair.sampled] == role->is_hand_part[pair.field] || IsHeld(pair_roles_[i], i)) continue;
    if (!world_->is_active(i) || !world_->result(i).is_in_contact) continue;
    role->sum_of_weights_m += glm::length(world_->result(i).f_So_S.sum_m);
  }
}

double HapticNode::JawPress_N(std::size_t pair, std::span<const core::Pose> moved_X_WO) const {
  return scenario_.coupling.jaw_stiffness_N_per_m * std::max(world_->Depth_m(pair, moved_X_WO), 0.0);
}

// Opening force on the gripper's axis [N], positive opens, by virtual work: when the opening w grows by dw, each jaw
// moves outwards by dw/2, so normal forces N_l and N_r on the jaws do the work Q dw = (N_l + N_r) dw/2, with
//   N = k_jaw [N/m] * penetration [m] * max(0, cos(angle between contact force and outward axis)).
double HapticNode::JawForce_N(std::size_t role_index, std::span<const core::Pose> moved_X_WO) const {
  const Role& role = roles_[role_index];
  const std::span<const core::Pose> X_WO = moved_X_WO.empty() ? X_WO_ : moved_X_WO;
  if (!role.is_following) return 0.0;
  const glm::dvec3 axis_W = role.X_WC().rotate(glm::dvec3(1.0, 0.0, 0.0));
  double sum_N = 0.0;
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    const scene::Pair& pair = PairOf(i);
    const vps::PairResult& result = world_->result(i);
    if (!world_->is_active(i) || !result.is_in_contact) continue;
    for (const bool is_sampled : {true, false}) {
      const std::uint16_t part = is_sampled ? pair.sampled : pair.field;
      const bool is_left = static_cast<int>(part) == role.device.jaw_left;
      if (!is_left && static_cast<int>(part) != role.device.jaw_right) continue;
      const glm::dvec3 push_W = (is_sampled ? 1.0 : -1.0) * ForceDirectionOnSampled_W(result, X_WO[pair.sampled]);
      const double outwards = (is_left ? -1.0 : 1.0) * glm::dot(push_W, axis_W);
      sum_N += JawPress_N(i, moved_X_WO) * std::max(outwards, 0.0);
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
  // Echo each sample once: its chain ends with the first command that contains its effect.
  if (newest != nullptr && newest->valid() && newest->id != role.last_trace_through_physics) {
    through_physics = *newest;
    role.last_trace_through_physics = newest->id;
  }

  core::Header header;
  header.direct = role.sample.header.direct;
  header.through_physics = through_physics;
  core::DeviceCommand command =
      MakeCommand(role_index, header, role.F_Do_W, role.reaction_gain * role.reaction.F_Do_W, JawForce_N(role_index));
  if (HasField(role)) WriteContactField(*role.god_object, role.sample.X_WD, X_WO_, V_WO_, &command);
  outputs->commands.push_back(command);

  core::HapticProxy proxy;
  proxy.header = command.header;
  proxy.role_index = command.role_index;
  proxy.cycle = cycle_;
  proxy.X_WD = role.sample.X_WD;
  proxy.V_WD = role.sample.V_WD;
  proxy.X_WC = role.X_WC();
  proxy.opening_m = role.sample.opening_m;
  proxy.finger_rad = role.sample.finger_rad;
  proxy.is_in_contact = role.is_following && role.is_in_contact;
  proxy.is_engaged = role.is_following;
  proxy.F_Do_W = role.F_Do_W;
  outputs->proxies.push_back(proxy);
}

core::DeviceCommand HapticNode::MakeCommand(std::size_t role_index, const core::Header& header,
                                            const core::Wrench& F_coupling_Do_W, const core::Wrench& F_rest_Do_W,
                                            double grip_force_N) const {
  core::DeviceCommand command;
  command.header = header;
  command.role_index = static_cast<std::uint8_t>(role_index);
  const Role& role = roles_[role_index];
  if (!role.is_following) return command;
  command.F_Do_W = physics_gain_ * core::LimitForce(F_coupling_Do_W + F_rest_Do_W, force_cap_N_);
  command.grip_force_N = physics_gain_ * grip_force_N;
  if (role.god_object) command.p_CoCm_C = role.god_object->parameters().p_CoCm_C;
  if (!HasField(role)) return command;
  command.F_rest_Do_W = F_rest_Do_W;
  command.force_cap_N = force_cap_N_;
  command.gain = physics_gain_;
  return command;
}

// The field is that of a tool without mass: one with mass goes its own way between two commands.
bool HapticNode::HasField(const Role& role) const {
  return scenario_.coupling.has_field && role.is_following && role.god_object && !role.god_object->has_mass();
}

bool HapticNode::IsToReevaluate(const Inputs& inputs) const {
  if (cycle_ == 0 || !scenario_.coupling.is_reevaluated || inputs.physics == nullptr) return false;
  bool is_felt = false;
  for (const core::Reaction& reaction : inputs.reactions) {
    if (reaction.header.sequence == 0 || reaction.tick != inputs.physics->tick) return false;
    is_felt = is_felt || reaction.header.through_physics.valid();
  }
  return is_felt;
}

void HapticNode::Reevaluate(const Inputs& inputs, Outputs* outputs) const noexcept {
  outputs->commands.clear();
  outputs->proxies.clear();
  std::fill(outputs->contacts_updated.begin(), outputs->contacts_updated.end(), 0);
  outputs->is_collisions_updated = false;
  outputs->is_in_contact = false;
  MoveObjects(inputs);
  for (std::size_t r = 0; r < roles_.size(); ++r) outputs->commands.push_back(ReevaluateRole(r, inputs));
}

// As UpdatePhysics and PlaceObjects do, but beside the node's own poses. The world's SetPose would use up the free
// distance of pairs that are apart.
void HapticNode::MoveObjects(const Inputs& inputs) const {
  moved_X_WO_ = X_WO_;
  moved_V_WO_ = V_WO_;
  if (inputs.physics != nullptr) {
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object >= moved_X_WO_.size()) continue;
      moved_X_WO_[body.object] = body.X_WO;
      moved_V_WO_[body.object] = body.V_WO;
    }
  }
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner != scene::Owner::kHand || object.role < 0) continue;
    const auto r = static_cast<std::size_t>(object.role);
    const double opening_m = NewestOf(inputs.devices, r, roles_[r].sample).opening_m;
    moved_X_WO_[i] = scene::PartPose(object.part, roles_[r].X_WC(), opening_m);
  }
}

core::DeviceCommand HapticNode::ReevaluateRole(std::size_t role_index, const Inputs& inputs) const {
  const Role& role = roles_[role_index];
  const core::DeviceState& sample = NewestOf(inputs.devices, role_index, role.sample);
  const core::Reaction& reaction = NewestOf(inputs.reactions, role_index, role.reaction);
  const double gain = reaction.header.sequence != role.reaction.header.sequence ? 1.0 : role.reaction_gain;
  core::Header header;
  header.direct = sample.header.direct;
  header.through_physics = reaction.header.through_physics;
  const int ignored_object = role.has_fingers ? -1 : IgnoredObject(reaction, gain);
  const double grip_force_N = JawForce_N(role_index, moved_X_WO_);
  const core::Wrench F_rest_Do_W = gain * reaction.F_Do_W;
  if (!role.god_object || !role.is_following) {
    const core::Wrench F_coupling_Do_W = PreviewCoupling(role, sample.X_WD, ignored_object);
    return MakeCommand(role_index, header, F_coupling_Do_W, F_rest_Do_W, grip_force_N);
  }
  vps::GodObject god_object = *role.god_object;
  vps::ToolContact contact;
  world_->HandPlanes(role.is_hand_part, &contact, ignored_object, moved_X_WO_);
  const core::Wrench F_coupling_Do_W = god_object.Step(sample.X_WD, contact, moved_X_WO_);
  core::DeviceCommand command = MakeCommand(role_index, header, F_coupling_Do_W, F_rest_Do_W, grip_force_N);
  if (HasField(role)) WriteContactField(god_object, sample.X_WD, moved_X_WO_, moved_V_WO_, &command);
  return command;
}

core::Wrench HapticNode::PreviewCoupling(const Role& role, const core::Pose& X_WD, int ignored_object) const {
  if (!role.is_following) return {};
  vps::VirtualCoupling coupling = role.coupling;
  vps::CouplingContact contact;
  world_->HandContact(role.is_hand_part, coupling.X_WC(), &contact, ignored_object, moved_X_WO_);
  return coupling.Step(X_WD, contact);
}

void HapticNode::FillContacts(const Inputs& inputs, Outputs* outputs) {
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    PairRole& pair_role = pair_roles_[i];
    const std::uint16_t slot = pair_role.scenario_pair;
    core::ContactSet& set = outputs->contacts[slot];
    outputs->contacts_updated[slot] = 0;
    if (!pair_role.is_published) continue;
    if (!collision::FillContactUpdate(*world_, i, slot, &pair_role.empty_sets_left, &set)) continue;
    set.cycle = cycle_;
    if (inputs.physics != nullptr) set.header.through_physics = inputs.physics->header.through_physics;
    ShareHandContact(i, pair_role, &set);
    outputs->contacts_updated[slot] = 1;
  }
}

// After FillContacts, as contact and force of a published pair are those that are sent.
void HapticNode::FillCollisions(Outputs* outputs) const {
  outputs->is_collisions_updated = cycle_ % kCollisionsPeriod_cycles == 0;
  if (!outputs->is_collisions_updated) return;
  core::CollisionMatrix& matrix = outputs->collisions;
  matrix = {};
  matrix.cycle = cycle_;
  for (std::size_t i = 0; i < pair_roles_.size(); ++i) {
    const PairRole& pair_role = pair_roles_[i];
    const scene::Pair& pair = PairOf(i);
    const vps::PairResult& result = world_->result(i);
    const core::ContactSet& set = outputs->contacts[pair_role.scenario_pair];
    if (!world_->is_active(i) || !(pair_role.is_published ? set.is_in_contact : result.is_in_contact)) continue;
    const core::Wrench& F_So_W = pair_role.is_published ? set.F_So_W : result.F_So_W;
    const double force_N = IsHeld(pair_role, i) ? JawPress_N(i) : glm::length(F_So_W.force_N);
    const double depth_m = std::max(-result.signed_distance_m, 0.0);
    collision::AddCollision({pair_role.scenario_pair, pair.sampled, pair.field, static_cast<float>(depth_m),
                             static_cast<float>(force_N), static_cast<float>(result.force_error_N)},
                            &matrix);
  }
}

// Distributes the coupling's wrench F_Do over the hand's contact pairs i in proportion to their penetration sums,
//   F_i = F_Do |s_i| / sum_j |s_j|,
// so that the objects together receive the opposite of the hand's wrench.
void HapticNode::ShareHandContact(std::size_t pair, const PairRole& pair_role, core::ContactSet* set) const {
  const int role_index = std::max(pair_role.sampled_role, pair_role.field_role);
  if (role_index < 0) return;
  const Role& role = roles_[static_cast<std::size_t>(role_index)];
  set->header.direct = role.sample.header.direct;
  set->F_So_W = {};
  if (role.god_object) {
    if (role.is_following && !IsHeld(pair_role, pair)) {
      WriteToolContact(pair, role, pair_role.sampled_role >= 0, set);
      return;
    }
    for (core::ContactPlane& plane : set->planes) {
      StickAt(PoseAtD(role, set->sampled_body), PoseAtD(role, set->field_body), glm::dvec3(0.0), &plane);
    }
    return;
  }
  if (!set->is_in_contact || role.sum_of_weights_m <= 0.0 || IsHeld(pair_role, pair)) return;
  const double share = glm::length(world_->result(pair).f_So_S.sum_m) / role.sum_of_weights_m;
  const bool is_hand_sampled = pair_role.sampled_role >= 0;
  const glm::dvec3 p_SoDo_W = role.sample.X_WD.translation - X_WO_[set->sampled_body].translation;
  set->F_So_W = core::ShiftWrench((is_hand_sampled ? share : -share) * role.F_Do_W, p_SoDo_W);
  for (core::ContactPlane& plane : set->planes)
    plane.stiffness_N_per_m *= static_cast<float>(share * role.stiffness_share);
}

// Of a part of the hand where the device has it, of another object where it is.
core::Pose HapticNode::PoseAtD(const Role& role, std::uint16_t object) const {
  if (role.is_hand_part[object] == 0) return X_WO_[object];
  return scene::PartPose(scenario_.objects[object].part, role.sample.X_WD, role.sample.opening_m);
}

// The god object knows the force at each place. physics_node evaluates planes at the device pose D, where they are as
// deep as the spring is long: with that stiffness a plane pushes the object by what the hand feels of it. One that is
// apart there keeps its own, for the ticks until the next cycle. With the same stiffness friction drags the object by
// what the hand feels of that: p_S sticks where it is as far from D along the plane. An object that is dragged by more
// tips under a hand that feels nothing of it and goes along.
void HapticNode::WriteToolContact(std::size_t pair, const Role& role, bool is_hand_sampled,
                                  core::ContactSet* set) const {
  const core::Pose X_WS = PoseAtD(role, set->sampled_body);
  const core::Pose X_WG = PoseAtD(role, set->field_body);
  // All of them, those that fade out, too: a hand that squeezes a part has large forces against each other, whose sum
  // alone is what the hand feels.
  const glm::dvec3 p_WSo = X_WO_[set->sampled_body].translation;
  const double factor = role.books.Factor(role.objects_N);
  for (const vps::HeldContact& contact : role.god_object->contacts()) {
    if (vps::CollisionWorld::PairOfHandPlane(contact.id) != pair) continue;
    const glm::dvec3 on_hand_N = contact.normal_N * contact.n_W + contact.tangent_W_N;
    const glm::dvec3 force_N = (is_hand_sampled ? factor : -factor) * on_hand_N;
    set->F_So_W += {force_N, glm::cross(contact.p_W - p_WSo, force_N)};
  }
  for (core::ContactPlane& plane : set->planes) {
    const std::uint32_t id = vps::CollisionWorld::HandPlaneId(pair, plane);
    double normal_N = 0.0;
    glm::dvec3 tangent_W_N(0.0);
    for (const vps::HeldContact& contact : role.god_object->contacts()) {
      if (contact.id != id || contact.cycles_lost > 0 || contact.is_turned) continue;
      normal_N = contact.normal_N;
      tangent_W_N = contact.tangent_W_N;
    }
    const double depth_m =
        -glm::dot(X_WG.rotate(glm::dvec3(plane.n_G)), X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G));
    set->is_in_contact = set->is_in_contact || normal_N > 0.0;
    glm::dvec3 slip_W(0.0);
    if (depth_m > 0.0) {
      const double most_N_per_m = kMaxPlaneStiffness * scenario_.coupling.stiffness_N_per_m;
      plane.stiffness_N_per_m = static_cast<float>(std::min(factor * normal_N / depth_m, most_N_per_m));
      if (normal_N > 0.0) slip_W = (is_hand_sampled ? -1.0 : 1.0) * depth_m / normal_N * tangent_W_N;
    }
    StickAt(X_WS, X_WG, slip_W, &plane);
  }
  const bool is_over = role.objects_N == glm::dvec3(0.0) && !set->is_in_contact;
  if (!is_over || pair != role.owing_pair || role.owing_object == core::kNoObject) return;
  const glm::dvec3 force_N = (is_hand_sampled ? 1.0 : -1.0) * role.books.Owed_N();
  set->F_So_W = {force_N, glm::cross(X_WO_[role.owing_object] * role.p_O_owing - p_WSo, force_N)};
}

}  // namespace haptic_node
