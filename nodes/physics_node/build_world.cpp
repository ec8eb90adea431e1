#include "nodes/physics_node/build_world.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "nodes/physics_node/location_text.hpp"

namespace physics_node {
namespace {

core::Pose PoseOf(const scene::Scenario& scenario, int object) {
  return object < 0 ? core::Pose{} : scenario.objects[static_cast<std::size_t>(object)].X_WO;
}

physics::JointAxisParams AxisOf(const scene::Mechanism& m) {
  return {m.lower,
          m.upper,
          m.damping,
          m.motor_speed,
          m.motor_limit,
          m.is_locked ? 1.0 : 0.0,
          m.servo_stiffness_Nm_per_rad,
          m.servo_damping_Nm_s_per_rad,
          m.start_rad};
}

physics::HingeParams HingeOf(const scene::Mechanism& m) {
  physics::HingeParams p;
  p.X_PJ = m.X_PJ;
  p.X_CJ = m.X_CJ;
  p.axis = AxisOf(m);
  p.has_detents = m.detents_rad.size() == 2;
  if (p.has_detents) {
    p.detents_rad[0] = m.detents_rad[0];
    p.detents_rad[1] = m.detents_rad[1];
  }
  p.detent_torque_Nm = m.detent_torque_Nm;
  return p;
}

physics::SnapParams SnapOf(const scene::Mechanism& m) {
  physics::SnapParams p;
  p.X_PJ = m.X_PJ;
  p.X_CJ = m.X_CJ;
  p.engage_force_N = m.engage_force_N;
  p.release_force_N = m.release_force_N;
  p.travel_m = m.travel_m;
  for (const glm::dvec2& point : m.profile) {
    const auto at = static_cast<std::size_t>(p.profile.num_points++);
    p.profile.z_m[at] = point.x;
    p.profile.share[at] = point.y / m.engage_force_N;
  }
  p.guide_length_m = m.guide_length_m;
  p.lateral_tolerance_m = m.lateral_tolerance_m;
  p.tilt_tolerance_rad = m.tilt_tolerance_rad;
  p.stiffness_N_per_m = m.stiffness_N_per_m;
  p.stiffness_Nm_per_rad = m.stiffness_Nm_per_rad;
  p.damping_N_s_per_m = m.damping;
  p.is_initially_engaged = m.is_initially_engaged;
  return p;
}

physics::HookAndLoopParams PatchesOf(const scene::Scenario& scenario, const scene::Mechanism& m) {
  physics::HookAndLoopParams p;
  p.p_PPatch_m = m.patches_m;
  p.X_PC = PoseOf(scenario, m.parent).inverse() * PoseOf(scenario, m.child);
  p.release_force_N = m.release_force_N;
  p.stiffness_N_per_m = m.stiffness_N_per_m;
  p.damping_N_s_per_m = m.damping;
  return p;
}

bool IsPhysics(const scene::Scenario& scenario, int object) {
  return scenario.objects[static_cast<std::size_t>(object)].owner == scene::Owner::kPhysics;
}

// Scenario pair of two objects, in either order.
int FindPair(const scene::Scenario& scenario, int a, int b) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const scene::Pair& pair = scenario.pairs[i];
    if ((pair.sampled == a && pair.field == b) || (pair.sampled == b && pair.field == a)) return static_cast<int>(i);
  }
  return kNone;
}

core::Result<void> AddBodies(const scene::Scenario& scenario, const std::vector<physics::MassProperties>& masses,
                             BuiltWorld* built) {
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    physics::BodyParams params;
    params.X_WO = object.X_WO;
    params.V_WO = object.V_WO;
    params.kind = object.owner == scene::Owner::kPhysics ? physics::BodyKind::kDynamic
                  : object.owner == scene::Owner::kHand  ? physics::BodyKind::kKinematic
                                                         : physics::BodyKind::kFixed;
    if (params.kind == physics::BodyKind::kDynamic) params.mass = masses[i];
    const auto body = built->world->AddBody(params);
    if (!body) {
      return core::Fail(body.error().code,
                        LocationPrefix(object.location) + "object '" + object.name + "': " + body.error().detail);
    }
    built->body_of_object.push_back(*body);
  }
  return {};
}

// With a god object a hand's planes say where they stick: friction on the object is then what the hand feels of it.
physics::ContactKind KindOf(const scene::Scenario& scenario, const scene::Pair& pair) {
  if (scenario.contact_input == scene::ContactInput::kManifold) return physics::ContactKind::kHard;
  const auto is_of_hand = [&](std::uint16_t object) { return scenario.objects[object].owner == scene::Owner::kHand; };
  const bool has_hand = is_of_hand(pair.sampled) || is_of_hand(pair.field);
  if (has_hand && scenario.coupling.type == "god_object") return physics::ContactKind::kElastic;
  return has_hand || scenario.method == "paper" ? physics::ContactKind::kCompliant : physics::ContactKind::kPassive;
}

core::Result<void> AddPairs(const scene::Scenario& scenario, BuiltWorld* built) {
  for (const scene::Pair& pair : scenario.pairs) {
    if (!IsPhysics(scenario, pair.sampled) && !IsPhysics(scenario, pair.field)) {
      built->contact_of_pair.push_back(kNone);
      continue;
    }
    const auto contact = built->world->AddContactPair(built->body_of_object[pair.sampled],
                                                      built->body_of_object[pair.field], KindOf(scenario, pair));
    if (!contact) return core::Fail(contact.error().code, LocationPrefix(pair.location) + contact.error().detail);
    built->contact_of_pair.push_back(*contact);
  }
  return {};
}

core::Result<void> AddMechanisms(const scene::Scenario& scenario, BuiltWorld* built) {
  for (const scene::Mechanism& m : scenario.mechanisms) {
    std::unique_ptr<physics::Mechanism> mechanism;
    built->hinges.push_back(nullptr);
    built->snaps.push_back(nullptr);
    built->patches.push_back(nullptr);
    built->sheet_hooks.push_back(nullptr);
    switch (m.kind) {
      case scene::MechanismKind::kHinge: {
        auto hinge = std::make_unique<physics::Hinge>(HingeOf(m));
        built->hinges.back() = hinge.get();
        mechanism = std::move(hinge);
        break;
      }
      case scene::MechanismKind::kSlider:
        mechanism = std::make_unique<physics::Slider>(physics::SliderParams{m.X_PJ, m.X_CJ, AxisOf(m)});
        break;
      case scene::MechanismKind::kSnap: {
        auto snap = std::make_unique<physics::Snap>(SnapOf(m));
        built->snaps.back() = snap.get();
        mechanism = std::move(snap);
        break;
      }
      case scene::MechanismKind::kHookAndLoop: {
        if (scenario.objects[static_cast<std::size_t>(m.child)].sheet) {
          auto hooks = std::make_unique<physics::ClothHooks>(static_cast<int>(m.patches_m.size()));
          built->sheet_hooks.back() = hooks.get();
          mechanism = std::move(hooks);
          break;
        }
        auto patches = std::make_unique<physics::HookAndLoop>(PatchesOf(scenario, m));
        built->patches.back() = patches.get();
        mechanism = std::move(patches);
        break;
      }
    }
    const auto body_of = [&](int object) {
      return object < 0 ? built->world->world_body() : built->body_of_object[static_cast<std::size_t>(object)];
    };
    const auto index = built->world->AddMechanism(body_of(m.parent), body_of(m.child), std::move(mechanism));
    if (!index) {
      return core::Fail(index.error().code,
                        LocationPrefix(m.location) + "mechanism '" + m.name + "': " + index.error().detail);
    }
    built->mechanism_of.push_back(*index);
  }
  return {};
}

// A lever hangs by a hinge on something that does not move freely. Jaws move it by their contacts; a grasp would couple
// all six degrees of freedom of the hand to a body with one, and load its axis.
bool IsLever(const scene::Scenario& scenario, int object) {
  return std::any_of(scenario.mechanisms.begin(), scenario.mechanisms.end(), [&](const scene::Mechanism& m) {
    return m.kind == scene::MechanismKind::kHinge && m.child == object &&
           (m.parent < 0 || !IsPhysics(scenario, m.parent));
  });
}

core::Result<void> AddHoldables(const scene::Scenario& scenario, BuiltWorld* built) {
  const scene::Coupling& c = scenario.coupling;
  const physics::SpringCouplingParams params{c.grasp_stiffness_N_per_m, c.grasp_damping_N_s_per_m,
                                             c.grasp_stiffness_Nm_per_rad, c.grasp_damping_Nm_s_per_rad};
  for (std::size_t role = 0; role < scenario.devices.size(); ++role) {
    const scene::Device& device = scenario.devices[role];
    if (device.palm < 0 || device.jaw_left < 0 || device.jaw_right < 0) continue;
    for (std::size_t object = 0; object < scenario.objects.size(); ++object) {
      const int o = static_cast<int>(object);
      if (!IsPhysics(scenario, o) || IsLever(scenario, o)) continue;
      BuiltWorld::Holdable holdable;
      holdable.role = static_cast<int>(role);
      holdable.object = o;
      holdable.left_pair = FindPair(scenario, device.jaw_left, o);
      holdable.right_pair = FindPair(scenario, device.jaw_right, o);
      if (holdable.left_pair == kNone || holdable.right_pair == kNone) continue;
      for (const int part : {device.palm, device.jaw_left, device.jaw_right}) {
        const int pair = FindPair(scenario, part, o);
        if (pair != kNone) {
          holdable.hand_contacts.push_back(built->contact_of_pair[static_cast<std::size_t>(pair)]);
        }
      }
      auto coupling = std::make_unique<physics::SpringCoupling>(params);
      if (c.is_grip_by_friction) coupling->SetGripLimit({});
      holdable.coupling = coupling.get();
      const auto index = built->world->AddMechanism(built->body_of_object[static_cast<std::size_t>(device.palm)],
                                                    built->body_of_object[object], std::move(coupling));
      if (!index) return core::Fail(index.error().code, index.error().detail);
      holdable.mechanism = *index;
      built->holdables.push_back(std::move(holdable));
    }
  }
  return {};
}

void AddFingerHolds(const scene::Scenario& scenario, BuiltWorld* built) {
  for (std::size_t role = 0; role < scenario.devices.size(); ++role) {
    for (std::size_t object = 0; object < scenario.objects.size(); ++object) {
      const int o = static_cast<int>(object);
      if (!IsPhysics(scenario, o) || scenario.objects[object].finger_link || IsLever(scenario, o)) continue;
      BuiltWorld::FingerHold hold;
      hold.role = static_cast<int>(role);
      hold.object = o;
      for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
        const scene::Pair& pair = scenario.pairs[i];
        if (pair.sampled != o && pair.field != o) continue;
        const auto& link = scenario.objects[pair.sampled == o ? pair.field : pair.sampled].finger_link;
        if (!link || link->role != hold.role) continue;
        (link->finger == 0 ? hold.thumb_contacts : hold.finger_contacts).push_back(built->contact_of_pair[i]);
      }
      if (!hold.thumb_contacts.empty() && !hold.finger_contacts.empty()) built->finger_holds.push_back(std::move(hold));
    }
  }
}

}  // namespace

core::Result<BuiltWorld> BuildWorld(const scene::Scenario& scenario,
                                    const std::vector<physics::MassProperties>& mass_of_object) {
  BuiltWorld built;
  physics::World::Options options;
  options.gravity_W_m_per_s2 = scenario.gravity_m_per_s2;
  built.world = std::make_unique<physics::World>(options);
  if (mass_of_object.size() != scenario.objects.size()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "BuildWorld: needs one entry of mass properties per object");
  }
  core::Result<void> part = AddBodies(scenario, mass_of_object, &built);
  if (part) part = AddPairs(scenario, &built);
  if (part) part = AddMechanisms(scenario, &built);
  if (part) part = AddHoldables(scenario, &built);
  if (!part) return core::Fail(part.error().code, part.error().detail);
  AddFingerHolds(scenario, &built);
  return built;
}

}  // namespace physics_node
