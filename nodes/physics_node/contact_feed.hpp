#pragma once

#include <cstdint>
#include <vector>

#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/grasp_keeper.hpp"
#include "nodes/physics_node/hands.hpp"
#include "nodes/physics_node/own_contacts.hpp"
#include "nodes/physics_node/ports.hpp"
#include "physics/checkpoint.hpp"
#include "scene/scenario.hpp"

namespace physics_node {

// Feeds contacts into the world: those that haptic_node sends, while they are fresh, and those that this node computes
// itself.
class ContactFeed {
 public:
  // All of them must outlive the feed.
  ContactFeed(const scene::Scenario& scenario, BuiltWorld* built);

  void SetActive(std::size_t pair, bool is_active) { contacts_[pair].is_active = is_active; }
  // Applies the received sets. Planes stay in the world until a newer set replaces them or they are stale.
  void ApplyReceived(const Inputs& inputs, const Hands& hands);
  // On S of a pair whose hand is apart, about S's origin, in this tick: what a contact that is over still owes the
  // object (haptic_node/contact_books.hpp).
  [[nodiscard]] const core::Wrench& owed_So_W(std::size_t pair) const { return owed_So_W_[pair]; }
  // Computes and applies this node's own pairs at the current poses.
  void ApplyOwn(OwnContacts* own, std::uint64_t tick, std::int64_t now_ns);

  // Contact of a jaw of `hand` in `pair`; `outwards` is -1 for the left jaw, +1 for the right one.
  [[nodiscard]] GraspKeeper::JawContact Jaw(const Inputs& inputs, int pair, const Hand& hand, double outwards) const;

  void ExchangeState(physics::Checkpoint* checkpoint);

 private:
  struct Contact {
    std::uint64_t sequence = 0;  // of the set in the world
    bool is_active = true;
    bool is_fresh = false;
  };

  void Feed(int slot, const core::ContactSet& set);
  void ApplyOwed();

  const scene::Scenario& scenario_;
  BuiltWorld* built_;
  std::vector<Contact> contacts_;        // per scenario pair
  std::vector<core::Wrench> owed_So_W_;  // per scenario pair
};

}  // namespace physics_node
