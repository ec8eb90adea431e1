#include "nodes/physics_node/grasp_keeper.hpp"

#include <cmath>

namespace physics_node {

GraspKeeper::GraspKeeper(BuiltWorld* built) : built_(built), watches_(built->holdables.size()) {
  held_.fill(kNone);
}

GraspKeeper::Change GraspKeeper::Update(std::size_t holdable, const JawContact& left, const JawContact& right,
                                        double opening_m, const glm::dvec3& p_W) {
  const BuiltWorld::Holdable& h = built_->holdables[holdable];
  Watch& watch = watches_[holdable];
  const int held = held_[static_cast<std::size_t>(h.role)];

  if (held != static_cast<int>(holdable)) {
    const bool is_squeezed = left.is_reported && left.is_squeezed && right.is_reported && right.is_squeezed;
    watch.press_ticks = is_squeezed && held == kNone ? watch.press_ticks + 1 : 0;
    return watch.press_ticks >= kPressTicks ? Attach(holdable, opening_m, p_W) : Change::kUnchanged;
  }

  const double allowed_m = glm::length(h.coupling->deflection_P_m()) + kLostMargin_m;
  const auto is_lost = [&](const JawContact& jaw) {
    return jaw.is_loose || (jaw.is_reported ? jaw.gap_m > allowed_m : opening_m > watch.opening_m + kReopenMargin_m);
  };
  watch.lost_ticks = is_lost(left) || is_lost(right) ? watch.lost_ticks + 1 : 0;
  if (opening_m > watch.opening_m + kOpenMargin_m || watch.lost_ticks >= kLostTicks) return Detach(holdable);
  return Change::kUnchanged;
}

void GraspKeeper::ExchangeState(physics::Checkpoint* checkpoint) {
  for (Watch& watch : watches_) checkpoint->Exchange(&watch);
  checkpoint->Exchange(&held_);
}

GraspKeeper::Change GraspKeeper::Attach(std::size_t holdable, double opening_m, const glm::dvec3& p_W) {
  BuiltWorld::Holdable& h = built_->holdables[holdable];
  const physics::World& world = *built_->world;
  held_[static_cast<std::size_t>(h.role)] = static_cast<int>(holdable);
  watches_[holdable] = Watch{0, 0, opening_m};
  h.coupling->Attach(world.X_WO(world.parent_of(h.mechanism)), world.X_WO(world.child_of(h.mechanism)), p_W);
  for (const int contact : h.hand_contacts) built_->world->SetContactMuted(contact, true);
  return Change::kAttached;
}

GraspKeeper::Change GraspKeeper::Detach(std::size_t holdable) {
  BuiltWorld::Holdable& h = built_->holdables[holdable];
  held_[static_cast<std::size_t>(h.role)] = kNone;
  watches_[holdable] = Watch{};
  h.coupling->Detach();
  for (const int contact : h.hand_contacts) built_->world->SetContactMuted(contact, false);
  return Change::kDetached;
}

}  // namespace physics_node
