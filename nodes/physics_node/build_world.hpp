#pragma once

#include <vector>

#include "core/result.hpp"
#include "physics/cloth/cloth_hooks.hpp"
#include "physics/hinge.hpp"
#include "physics/hook_and_loop.hpp"
#include "physics/slider.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/world.hpp"
#include "scene/scenario.hpp"

namespace physics_node {

constexpr int kNone = -1;

// A scenario as a physics::World, with maps from the scenario's indices to the world's. Every object is a body; only
// pairs with a physics-owned object are contact pairs, the others map to kNone.
struct BuiltWorld {
  std::unique_ptr<physics::World> world;
  std::vector<int> body_of_object;
  std::vector<int> contact_of_pair;
  std::vector<int> mechanism_of;        // by scenario mechanism
  std::vector<physics::Hinge*> hinges;  // by scenario mechanism; null unless of this kind
  std::vector<physics::Snap*> snaps;
  std::vector<physics::HookAndLoop*> patches;
  std::vector<physics::ClothHooks*> sheet_hooks;  // hook-and-loop that holds a sheet

  // A possible grasp: one for every role and physics-owned object that has a contact pair with both jaws.
  struct Holdable {
    int role = 0;
    int object = 0;
    int left_pair = kNone;  // scenario pair indices
    int right_pair = kNone;
    int mechanism = kNone;
    physics::SpringCoupling* coupling = nullptr;
    std::vector<int> hand_contacts;  // contact pairs of all hand parts with the object: without force while held
  };
  std::vector<Holdable> holdables;

  // What fingers can hold: one for every role with fingers and physics-owned object that both its thumb and another
  // finger can touch. Contacts are indices of the world.
  struct FingerHold {
    int role = 0;
    int object = 0;
    std::vector<int> thumb_contacts;
    std::vector<int> finger_contacts;
  };
  std::vector<FingerHold> finger_holds;
};

// `mass_of_object` has one entry per object; only those of physics-owned objects are used. Errors name file, line and
// object.
core::Result<BuiltWorld> BuildWorld(const scene::Scenario& scenario,
                                    const std::vector<physics::MassProperties>& mass_of_object);

// Digest of the data that a world is built from, as far as a checkpoint depends on them.
std::uint64_t ContentDigest(const scene::Scenario& scenario,
                            const std::vector<physics::MassProperties>& mass_of_object);

}  // namespace physics_node
