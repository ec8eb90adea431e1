#include "nodes/physics_node/physics_node.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>

#include "collision/collision_matrix.hpp"
#include "collision/load_masses.hpp"
#include "core/clock.hpp"
#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/contact_feed.hpp"
#include "nodes/physics_node/finger_watch.hpp"
#include "nodes/physics_node/grasp_keeper.hpp"
#include "nodes/physics_node/hands.hpp"
#include "nodes/physics_node/parameters.hpp"

namespace physics_node {
struct PhysicsNode::Impl {
  Impl(const scene::Scenario& s, BuiltWorld&& b)
      : scenario(s),
        built(std::move(b)),
        keeper(&built),
        fingers(&built),
        hands(scenario),
        feed(scenario, &built),
        parameters(scenario, built),
        changes(built.world.get(), parameters) {
    snap_states.resize(scenario.mechanisms.size());
    for (std::size_t i = 0; i < scenario.mechanisms.size(); ++i) {
      snap_states[i] = built.world->mechanism(built.mechanism_of[i]).state();
    }
    pinched.fill(kNone);
  }

  // None while nobody tests what bodies stand on.
  void ApplyGravity() {
    const bool is_withheld = !scenario.devices.empty() && hands.are_all_silent();
    built.world->SetGravity(is_withheld ? glm::dvec3(0.0) : scenario.gravity_m_per_s2);
  }

  ChangeOutcome Apply(const core::ParameterChange& change) {
    if (!parameters.Accepts(*built.world, change)) return {};
    const ParameterSlot& slot = *parameters.Find(change.name);
    const std::size_t i = slot.index;
    ChangeOutcome outcome{true};
    switch (slot.kind) {
      case ParameterKind::kPairActive:
        feed.SetActive(i, change.value != 0.0);
        own->SetActive(i, change.value != 0.0);
        break;
      case ParameterKind::kPairStiffness:
        outcome.injected_J =
            own->SetStiffness(i, change.value, X_WO(scenario.pairs[i].sampled), X_WO(scenario.pairs[i].field));
        break;
      case ParameterKind::kMechanismFigure:
        outcome = changes.Begin(slot, change);
        break;
      case ParameterKind::kSheetRelease:
        sheets->SetReleaseForce(i, change.value);
        break;
      case ParameterKind::kSheetActive:
        sheets->SetActive(static_cast<int>(i), change.value != 0.0);
        break;
    }
    return outcome;
  }

  [[nodiscard]] core::Pose X_WO(std::size_t object) const { return built.world->X_WO(built.body_of_object[object]); }

  void ReportSettled(Outputs* outputs) {
    changes.ReportSettled([&](const std::string& name, const physics::ChangeReport& report) {
      char text[96];
      std::snprintf(text, sizeof text, " settled at tick %llu, injected %.9g J",
                    static_cast<unsigned long long>(report.last_tick), report.injected_J);
      Emit(outputs, "parameter_settled", {name, text});
    });
  }

  void UpdateGrasps(const Inputs& inputs, Outputs* outputs) {
    for (std::size_t i = 0; i < built.holdables.size(); ++i) {
      const BuiltWorld::Holdable& h = built.holdables[i];
      const Hand& hand = hands[static_cast<std::size_t>(h.role)];
      if (hand.is_silent) continue;  // no grasp changes on outdated data
      GraspKeeper::JawContact left = feed.Jaw(inputs, h.left_pair, hand, -1.0);
      GraspKeeper::JawContact right = feed.Jaw(inputs, h.right_pair, hand, 1.0);
      if (scenario.coupling.is_grip_by_friction) {
        left.is_loose = !(left.gap_m < 0.0);
        right.is_loose = !(right.gap_m < 0.0);
      }
      const GraspKeeper::Change change = keeper.Update(i, left, right, hand.opening_m, GripPoint_W(h));
      if (scenario.coupling.is_grip_by_friction) LimitGrip(h, left, right);
      if (change == GraspKeeper::Change::kUnchanged) continue;
      Emit(outputs, change == GraspKeeper::Change::kAttached ? "grasp_attached" : "grasp_detached",
           {scenario.devices[static_cast<std::size_t>(h.role)].role, " ",
            scenario.objects[static_cast<std::size_t>(h.object)].name});
    }
  }

  // After the step, whose contacts say what presses.
  void WatchFingers(Outputs* outputs) {
    for (std::size_t role = 0; role < scenario.devices.size() && role < kMaxRoles; ++role) {
      const int before = fingers.held_by(role);
      fingers.Update(role);
      const int now = fingers.held_by(role);
      if (now == before) continue;
      for (const auto& [object, name] : {std::pair{before, "grasp_detached"}, std::pair{now, "grasp_attached"}}) {
        if (object == kNone) continue;
        Emit(outputs, name,
             {scenario.devices[role].role, " ", scenario.objects[static_cast<std::size_t>(object)].name});
      }
    }
  }

  void StepSheets(const Inputs& inputs, Outputs* outputs) {
    if (sheets->num_sheets() == 0) return;
    std::array<bool, kMaxRoles> is_hand_full{};
    for (std::size_t role = 0; role < kMaxRoles; ++role) is_hand_full[role] = keeper.held_by(role) != kNone;
    sheets->Step(tick, inputs, is_hand_full);
    for (std::size_t role = 0; role < scenario.devices.size() && role < kMaxRoles; ++role) {
      const int now = sheets->pinched_by(role);
      const int before = std::exchange(pinched[role], now);
      if (now == before) continue;
      for (const auto& [object, name] : {std::pair{before, "grasp_detached"}, std::pair{now, "grasp_attached"}}) {
        if (object == kNone) continue;
        Emit(outputs, name,
             {scenario.devices[role].role, " ", scenario.objects[static_cast<std::size_t>(object)].name});
      }
    }
  }

  // A jaw that is pressed in by d holds with mu k d, k the jaws' stiffness, and against turning with the mean distance
  // of what presses on it.
  void LimitGrip(const BuiltWorld::Holdable& h, const GraspKeeper::JawContact& left,
                 const GraspKeeper::JawContact& right) const {
    physics::GripLimit limit;
    const auto add = [&](const GraspKeeper::JawContact& jaw, int scenario_pair) {
      const auto pair = static_cast<std::size_t>(scenario_pair);
      const double pressed_m = jaw.is_reported ? std::max(0.0, -jaw.gap_m) : 0.0;
      const double force_N = scenario.pairs[pair].friction * scenario.coupling.jaw_stiffness_N_per_m * pressed_m;
      limit.force_N += force_N;
      limit.torque_Nm += force_N * built.world->PressedRadius_m(built.contact_of_pair[pair]);
    };
    add(left, h.left_pair);
    add(right, h.right_pair);
    h.coupling->SetGripLimit(limit);
  }

  // Half way between the contact points of the jaws, or between the jaws' frames when no planes are known.
  [[nodiscard]] glm::dvec3 GripPoint_W(const BuiltWorld::Holdable& h) const {
    const scene::Device& device = scenario.devices[static_cast<std::size_t>(h.role)];
    const int left = built.contact_of_pair[static_cast<std::size_t>(h.left_pair)];
    const int right = built.contact_of_pair[static_cast<std::size_t>(h.right_pair)];
    if (built.world->HasContactPlanes(left) && built.world->HasContactPlanes(right)) {
      return 0.5 * (built.world->DeepestPoint_W(left) + built.world->DeepestPoint_W(right));
    }
    const auto origin = [&](int object) {
      return built.world->X_WO(built.body_of_object[static_cast<std::size_t>(object)]).translation;
    };
    return 0.5 * (origin(device.jaw_left) + origin(device.jaw_right));
  }

  // The detail is the parts, one after the other.
  void Emit(Outputs* outputs, const char* name, std::initializer_list<std::string_view> parts) const {
    if (outputs->events.full()) return;
    outputs->events.resize(outputs->events.size() + 1);
    core::Event& event = outputs->events.back();
    event.time_ns = now_ns;
    event.source = "physics_node";
    event.name = name;
    event.detail.clear();
    for (const std::string_view part : parts) event.detail += part;
  }

  void ReportMechanisms(Outputs* outputs) {
    for (std::size_t i = 0; i < scenario.mechanisms.size(); ++i) {
      const physics::Mechanism& m = built.world->mechanism(built.mechanism_of[i]);
      outputs->state.mechanisms.push_back({static_cast<std::uint16_t>(i), m.state(), m.position(), m.force()});
      if (m.state() == snap_states[i]) continue;
      const char* name = scenario.mechanisms[i].kind == scene::MechanismKind::kHinge         ? "hinge_flipped"
                         : scenario.mechanisms[i].kind == scene::MechanismKind::kHookAndLoop ? "patch_released"
                         : m.state() == 1                                                    ? "snap_engaged"
                                                                                             : "snap_released";
      snap_states[i] = m.state();
      Emit(outputs, name, {scenario.mechanisms[i].name});
    }
  }

  // Wrench of physics on this hand about D: the grasp, sheets, and mechanisms attached to one of its parts.
  [[nodiscard]] core::Wrench ReactionOn(std::size_t role) const {
    core::Wrench F_Do_W;
    const Hand& hand = hands[role];
    if (hand.is_silent) return F_Do_W;
    const glm::dvec3 p_WDo = hand.X_WD.translation;
    const int held = keeper.held_by(role);
    if (held != kNone) {
      F_Do_W += built.world->MechanismForceOnParent(built.holdables[static_cast<std::size_t>(held)].mechanism, p_WDo);
    }
    F_Do_W += sheets->ForceOnHand(role, p_WDo);
    for (std::size_t i = 0; i < scenario.mechanisms.size(); ++i) {
      const scene::Mechanism& m = scenario.mechanisms[i];
      const auto is_mine = [&](int object) {
        return object >= 0 && scenario.objects[static_cast<std::size_t>(object)].owner == scene::Owner::kHand &&
               scenario.objects[static_cast<std::size_t>(object)].role == static_cast<int>(role);
      };
      if (is_mine(m.parent)) F_Do_W += built.world->MechanismForceOnParent(built.mechanism_of[i], p_WDo);
      if (is_mine(m.child)) F_Do_W += -built.world->MechanismForceOnParent(built.mechanism_of[i], p_WDo);
    }
    return F_Do_W;
  }

  [[nodiscard]] bool IsOfHand(std::uint16_t object, std::size_t role) const {
    return scenario.objects[object].owner == scene::Owner::kHand &&
           scenario.objects[object].role == static_cast<int>(role);
  }

  // What the objects have got through each hand's contacts in this tick, with the opposite sign: on the hand.
  void AddContactImpulses() {
    if (!has_field) return;
    for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
      const int slot = built.contact_of_pair[i];
      if (slot == kNone) continue;
      core::Wrench F_So_W = feed.owed_So_W(i);
      if (built.world->contact(slot).num_pushing > 0) F_So_W += built.world->contact(slot).F_So_W;
      if (F_So_W.force_N == glm::dvec3(0.0)) continue;
      const scene::Pair& pair = scenario.pairs[i];
      const core::Wrench F_Wo_W = core::ShiftWrench(F_So_W, X_WO(pair.sampled).translation);
      for (std::size_t role = 0; role < scenario.devices.size() && role < kMaxRoles; ++role) {
        const auto is_moved = [&](std::uint16_t object) {
          return scenario.objects[object].owner == scene::Owner::kPhysics;
        };
        if (IsOfHand(pair.sampled, role) && is_moved(pair.field)) J_contact_Wo_W[role] += core::kTick_s * F_Wo_W;
        if (IsOfHand(pair.field, role) && is_moved(pair.sampled)) J_contact_Wo_W[role] += -core::kTick_s * F_Wo_W;
      }
    }
  }

  // Whether the hand acts on a movable object, so that its sample has reached this state through physics.
  [[nodiscard]] bool TouchesMovingObject(std::size_t role) const {
    if (keeper.held_by(role) != kNone || fingers.held_by(role) != kNone || sheets->pinched_by(role) != kNone)
      return true;
    for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
      if (built.contact_of_pair[i] == kNone || built.world->contact(built.contact_of_pair[i]).num_pushing == 0)
        continue;
      if (IsOfHand(scenario.pairs[i].sampled, role) || IsOfHand(scenario.pairs[i].field, role)) return true;
    }
    return false;
  }

  void ExchangeState(physics::Checkpoint* checkpoint) {
    checkpoint->Exchange(&tick);
    checkpoint->Exchange(&now_ns);
    hands.ExchangeState(checkpoint);
    feed.ExchangeState(checkpoint);
    for (int& state : snap_states) checkpoint->Exchange(&state);
    keeper.ExchangeState(checkpoint);
    fingers.ExchangeState(checkpoint);
    own->ExchangeState(checkpoint);
    sheets->ExchangeState(checkpoint);
    checkpoint->Exchange(&pinched);
    if (has_field) checkpoint->Exchange(&J_contact_Wo_W);
  }

  void Fill(Outputs* outputs) {
    core::PhysicsState& state = outputs->state;
    state.header = {};
    state.header.sequence = tick;
    state.header.publish_ns = now_ns;
    state.tick = tick;
    state.time_ns = static_cast<std::int64_t>(tick) * core::kTick_ns;
    state.bodies.clear();
    state.mechanisms.clear();
    for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
      if (scenario.objects[i].owner != scene::Owner::kPhysics) continue;
      const int body = built.body_of_object[i];
      state.bodies.push_back({static_cast<std::uint16_t>(i), built.world->X_WO(body), built.world->V_WO(body)});
    }
    ReportMechanisms(outputs);
    state.is_in_contact = false;
    for (const int slot : built.contact_of_pair) {
      if (slot != kNone && built.world->contact(slot).num_pushing > 0) state.is_in_contact = true;
    }

    outputs->reactions.clear();
    for (std::size_t role = 0; role < scenario.devices.size() && role < kMaxRoles; ++role) {
      const Hand& hand = hands[role];
      core::Reaction reaction;
      reaction.header.sequence = tick;
      reaction.header.publish_ns = now_ns;
      reaction.role_index = static_cast<std::uint8_t>(role);
      reaction.tick = tick;
      const int held = keeper.held_by(role);
      if (held != kNone) {
        reaction.grasped_object = static_cast<std::uint16_t>(built.holdables[static_cast<std::size_t>(held)].object);
        state.is_in_contact = true;
      } else if (fingers.held_by(role) != kNone) {
        reaction.grasped_object = static_cast<std::uint16_t>(fingers.held_by(role));
      } else if (sheets->pinched_by(role) != kNone) {
        reaction.grasped_object = static_cast<std::uint16_t>(sheets->pinched_by(role));
        state.is_in_contact = true;
      }
      reaction.F_Do_W = ReactionOn(role);
      reaction.J_contact_Wo_W = J_contact_Wo_W[role];
      if (!hand.is_silent) {
        reaction.header.direct = hand.direct;
        if (TouchesMovingObject(role)) reaction.header.through_physics = hand.direct;
        if (hand.direct.origin_ns >= state.header.direct.origin_ns) state.header.direct = hand.direct;
        const core::Trace& through = reaction.header.through_physics;
        if (through.valid() && through.origin_ns >= state.header.through_physics.origin_ns) {
          state.header.through_physics = through;
        }
      }
      outputs->reactions.push_back(reaction);
    }
  }

  scene::Scenario scenario;
  core::SerialFor serial;
  std::unique_ptr<OwnContacts> own;
  BuiltWorld built;
  GraspKeeper keeper;
  FingerWatch fingers;
  Hands hands;
  ContactFeed feed;
  std::unique_ptr<SheetKeeper> sheets;
  std::array<int, kMaxRoles> pinched{};                // object per role, as last reported
  bool has_field = false;                              // haptic_node keeps books of what hand and objects get
  std::array<core::Wrench, kMaxRoles> J_contact_Wo_W;  // per role, since the start
  Parameters parameters;
  LiveChanges changes;
  std::vector<int> snap_states;  // per mechanism, as last reported
  std::uint64_t content = 0;
  std::uint64_t tick = 0;
  std::int64_t now_ns = 0;
};

PhysicsNode::PhysicsNode(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PhysicsNode::~PhysicsNode() = default;

core::Result<std::unique_ptr<PhysicsNode>> PhysicsNode::Create(const scene::Scenario& scenario,
                                                               const Options& options) {
  const auto masses = collision::LoadMasses(scenario);
  if (!masses) return core::Fail(masses.error().code, masses.error().detail);
  return Create(scenario, *masses, options);
}

core::Result<std::unique_ptr<PhysicsNode>> PhysicsNode::Create(
    const scene::Scenario& scenario, const std::vector<physics::MassProperties>& mass_of_object,
    const Options& options) {
  if (scenario.mechanisms.size() > core::kMaxMechanisms) {
    return core::Fail(core::ErrorCode::kResource,
                      "scenario has more than " + std::to_string(core::kMaxMechanisms) + " mechanisms; leave some out");
  }
  const auto moving = std::count_if(scenario.objects.begin(), scenario.objects.end(),
                                    [](const scene::Object& o) { return o.owner == scene::Owner::kPhysics; });
  if (moving > static_cast<std::ptrdiff_t>(core::kMaxBodies)) {
    return core::Fail(core::ErrorCode::kResource, "scenario has more than " + std::to_string(core::kMaxBodies) +
                                                      " objects with owner=\"physics\"; leave some out or fix them");
  }
  auto built = BuildWorld(scenario, mass_of_object);
  if (!built) return core::Fail(built.error().code, built.error().detail);
  auto impl = std::make_unique<Impl>(scenario, std::move(*built));
  auto own = OwnContacts::Create(impl->scenario, options.workers != nullptr ? *options.workers : impl->serial,
                                 options.collision);
  if (!own) return core::Fail(own.error().code, own.error().detail);
  impl->own = std::move(*own);
  auto sheets = SheetKeeper::Create(
      impl->scenario, mass_of_object, &impl->built, options.collision,
      options.workers != nullptr ? options.workers : static_cast<core::ParallelFor*>(&impl->serial));
  if (!sheets) return core::Fail(sheets.error().code, sheets.error().detail);
  impl->sheets = std::move(*sheets);
  impl->has_field = scenario.coupling.type == "god_object" && scenario.coupling.has_field;
  impl->content = ContentDigest(scenario, mass_of_object);
  return std::unique_ptr<PhysicsNode>(new PhysicsNode(std::move(impl)));
}

void PhysicsNode::Step(const Inputs& inputs, Outputs* outputs) noexcept {
  Impl& n = *impl_;
  ++n.tick;
  n.now_ns = inputs.now_ns;
  outputs->events.clear();
  outputs->outcomes.clear();
  for (std::size_t i = 0; i < inputs.num_changes; ++i) outputs->outcomes.push_back(n.Apply(inputs.changes[i]));
  n.hands.Update(inputs, n.tick);
  n.hands.Place(&n.built);
  n.feed.ApplyReceived(inputs, n.hands);
  n.feed.ApplyOwn(n.own.get(), n.tick, n.now_ns);
  n.UpdateGrasps(inputs, outputs);
  n.StepSheets(inputs, outputs);
  n.ApplyGravity();
  n.built.world->Step(core::kTick_s);
  n.AddContactImpulses();
  n.WatchFingers(outputs);
  n.ReportSettled(outputs);
  n.Fill(outputs);
  outputs->state.state_hash = StateHash();
}

std::vector<std::string> PhysicsNode::ParameterNames() const {
  return impl_->parameters.Names();
}
bool PhysicsNode::AcceptsParameter(const core::ParameterChange& change) const {
  return impl_->parameters.Accepts(*impl_->built.world, change);
}
std::uint64_t PhysicsNode::tick() const {
  return impl_->tick;
}
physics::ImpulseBalance PhysicsNode::impulse_balance() const {
  return impl_->built.world->impulse_balance();
}
const physics::World& PhysicsNode::world() const {
  return *impl_->built.world;
}
void PhysicsNode::Save(Snapshot* snapshot) const {
  snapshot->tick = impl_->tick;
  snapshot->node.BeginWriting();
  impl_->ExchangeState(&snapshot->node);
  impl_->built.world->Save(&snapshot->world);
}
bool PhysicsNode::is_quiet() const {
  return impl_->sheets->is_idle();
}
core::Result<void> PhysicsNode::Restore(Snapshot* snapshot) {
  Snapshot here;
  Save(&here);
  if (here.node.bytes().size() != snapshot->node.bytes().size()) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "checkpoint: it was written by another version of the program; start without it");
  }
  if (auto restored = impl_->built.world->Restore(&snapshot->world); !restored) return restored;
  snapshot->node.BeginReading();
  impl_->ExchangeState(&snapshot->node);
  impl_->changes.FindPending();
  return {};
}
std::uint64_t PhysicsNode::content_digest() const {
  return impl_->content;
}
void PhysicsNode::FillCollisions(core::CollisionMatrix* matrix) const {
  *matrix = {};
  matrix->cycle = impl_->tick;
  const OwnContacts& own = *impl_->own;
  for (std::size_t i = 0; i < own.num_pairs(); ++i) {
    const std::size_t pair = own.scenario_pair(i);
    const core::ContactSet& set = own.set(i);
    if (!own.is_near(i) || !set.is_in_contact) continue;
    const double force_N = glm::length(world().contact(impl_->built.contact_of_pair[pair]).F_So_W.force_N);
    const double depth_m = std::max(-set.signed_distance_m, 0.0);
    collision::AddCollision(
        {static_cast<std::uint16_t>(pair), set.sampled_body, set.field_body, static_cast<float>(depth_m),
         static_cast<float>(force_N), static_cast<float>(own.force_error_N(i))},
        matrix);
  }
}
OwnContacts& PhysicsNode::own_contacts() {
  return *impl_->own;
}
SheetKeeper& PhysicsNode::sheets() {
  return *impl_->sheets;
}
std::uint64_t PhysicsNode::StateHash() const {
  return impl_->built.world->StateHash();
}

}  // namespace physics_node
