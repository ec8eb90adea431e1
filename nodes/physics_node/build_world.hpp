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

// A scenario as a physics::World, with the way back from the scenario's indices. Indices are kNone where physics has
// nothing: objects are bodies one to one, but only pairs with a physics-owned object are contact pairs here.
struct BuiltWorld {
  std::unique_ptr<physics::World> world;
  std::vector<int> body_of_object;
  std::vector<int> contact_of_pair;
  std::vector<int> mechanism_of;        // by scenario mechanism
  std::vector<physics::Hinge*> hinges;  // by scenario mechanism; null unless of this kind
  std::vector<physics::Snap*> snaps;
  std::vector<physics::HookAndLoop*> patches;
  std::vector<physics::ClothHooks*> sheet_hooks;  // hook-and-loop that holds a sheet

  // What a gripper could hold: one for every role and physics-owned object that both jaws have a contact pair with.
  struct Holdable {
    int role = 0;
    int object = 0;
    int left_pair = kNone;  // scenario pair indices
    int right_pair = kNone;
    int mechanism = kNone;
    physics::SpringCoupling* coupling = nullptr;
    std::vector<int> hand_contacts;  // World contact pairs of all hand parts with the object: muted while held
  };
  std::vector<Holdable> holdables;
};

// `mass_of_object` has one entry per object; only those of physics-owned objects are used.
core::Result<BuiltWorld> BuildWorld(const scene::Scenario& scenario,
                                    const std::vector<physics::MassProperties>& mass_of_object);

// Of what a world is built from, as far as a checkpoint depends on it.
std::uint64_t ContentDigest(const scene::Scenario& scenario,
                            const std::vector<physics::MassProperties>& mass_of_object);

// Mass and inertia of every physics-owned object from its mesh: of its density, or scaled to its mass. An open mesh
// (a sheet) with a given mass gets the inertia of its bounding box.
core::Result<std::vector<physics::MassProperties>> LoadMasses(const scene::Scenario& scenario);

}  // namespace physics_node
