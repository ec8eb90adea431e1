#include "nodes/physics_node/finger_watch.hpp"

#include <algorithm>

#include "nodes/physics_node/grasp_keeper.hpp"

namespace physics_node {

FingerWatch::FingerWatch(const BuiltWorld* built) : built_(built), ticks_(built->finger_holds.size()) {
  held_.fill(kNone);
}

bool FingerWatch::IsPressed(const std::vector<int>& contacts) const {
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](int contact) { return built_->world->contact(contact).num_pushing > 0; });
}

void FingerWatch::Update(std::size_t role) {
  for (std::size_t i = 0; i < built_->finger_holds.size(); ++i) {
    const BuiltWorld::FingerHold& hold = built_->finger_holds[i];
    if (hold.role != static_cast<int>(role)) continue;
    const bool is_held = held_[role] == hold.object;
    if (!is_held && held_[role] != kNone) {
      ticks_[i] = 0;
      continue;
    }
    const bool is_pressed = IsPressed(hold.thumb_contacts) && IsPressed(hold.finger_contacts);
    ticks_[i] = is_pressed != is_held ? ticks_[i] + 1 : 0;
    if (ticks_[i] < (is_held ? GraspKeeper::kLostTicks : GraspKeeper::kPressTicks)) continue;
    ticks_[i] = 0;
    held_[role] = is_held ? kNone : hold.object;
  }
}

void FingerWatch::ExchangeState(physics::Checkpoint* checkpoint) {
  for (int& ticks : ticks_) checkpoint->Exchange(&ticks);
  checkpoint->Exchange(&held_);
}

}  // namespace physics_node
