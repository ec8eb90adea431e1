#include "nodes/physics_node/contact_feed.hpp"

#include "nodes/physics_node/physics_node.hpp"

namespace physics_node {

ContactFeed::ContactFeed(const scene::Scenario& scenario, BuiltWorld* built)
    : scenario_(scenario), built_(built), contacts_(scenario.pairs.size()), owed_So_W_(scenario.pairs.size()) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_[i].is_active = scenario.pairs[i].is_active;
}

void ContactFeed::ApplyReceived(const Inputs& inputs, const Hands& hands) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    owed_So_W_[i] = {};
    if (built_->contact_of_pair[i] == kNone || scenario_.pairs[i].owner != scene::PairOwner::kHaptic) continue;
    const int slot = built_->contact_of_pair[i];
    Contact& contact = contacts_[i];
    const core::ContactSet* set = i < inputs.num_contacts ? &inputs.contacts[i] : nullptr;
    contact.is_fresh = set != nullptr && set->header.sequence != 0 && contact.is_active && !hands.are_all_silent() &&
                       hands.newest_cycle() <= set->cycle + PhysicsNode::kMaxAgeTicks;
    if (!contact.is_fresh) {
      if (contact.sequence != 0) built_->world->ClearContact(slot);
      contact.sequence = 0;
      continue;
    }
    if (set->header.sequence == contact.sequence) continue;
    contact.sequence = set->header.sequence;
    if (!set->is_in_contact) owed_So_W_[i] = set->F_So_W;
    Feed(slot, *set);
  }
  ApplyOwed();
}

// As loads on the objects, for one tick: no contact is there that could bear them.
void ContactFeed::ApplyOwed() {
  for (std::size_t object = 0; object < scenario_.objects.size(); ++object) {
    if (scenario_.objects[object].owner != scene::Owner::kPhysics) continue;
    core::Wrench load_Bo_W;
    for (std::size_t i = 0; i < owed_So_W_.size(); ++i) {
      const scene::Pair& pair = scenario_.pairs[i];
      if (pair.sampled == object) load_Bo_W += owed_So_W_[i];
      if (pair.field != object || owed_So_W_[i].force_N == glm::dvec3(0.0)) continue;
      const auto origin_W = [&](std::uint16_t o) { return built_->world->X_WO(built_->body_of_object[o]).translation; };
      load_Bo_W += -core::ShiftWrench(owed_So_W_[i], origin_W(pair.sampled) - origin_W(pair.field));
    }
    built_->world->SetLoad(built_->body_of_object[object], load_Bo_W);
  }
}

void ContactFeed::Feed(int slot, const core::ContactSet& set) {
  built_->world->SetContactPlanes(slot, set);
  if (scenario_.contact_input == scene::ContactInput::kWrench) {
    built_->world->SetContactWrench(slot, set.is_in_contact ? set.F_So_W : core::Wrench{});
  }
}

void ContactFeed::ApplyOwn(OwnContacts* own, std::uint64_t tick, std::int64_t now_ns) {
  if (own->num_pairs() == 0) return;
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    own->SetPose(i, built_->world->X_WO(built_->body_of_object[i]));
  }
  own->Step(tick, now_ns);
  for (std::size_t i = 0; i < own->num_pairs(); ++i) {
    const int slot = built_->contact_of_pair[own->scenario_pair(i)];
    if (own->is_near(i)) {
      Feed(slot, own->set(i));
    } else if (built_->world->HasContactPlanes(slot)) {
      built_->world->ClearContact(slot);
    }
  }
}

GraspKeeper::JawContact ContactFeed::Jaw(const Inputs& inputs, int pair, const Hand& hand, double outwards) const {
  const auto i = static_cast<std::size_t>(pair);
  GraspKeeper::JawContact jaw;
  jaw.is_reported = contacts_[i].is_fresh;
  if (!jaw.is_reported) return jaw;
  const core::ContactSet& set = inputs.contacts[i];
  // Direction of the force on S when the object pushes the jaw outwards.
  const bool is_jaw_sampled = scenario_.objects[scenario_.pairs[i].sampled].owner == scene::Owner::kHand;
  const glm::dvec3 direction_W = hand.X_WD.rotate({is_jaw_sampled ? outwards : -outwards, 0.0, 0.0});
  if (!set.planes.empty()) {
    // Planes give the gap at the current poses. The wrench cannot show a squeeze: it is the jaw's share of the force on
    // the whole hand, in which the forces of two opposing jaws cancel.
    jaw.gap_m = built_->world->SmallestGap_m(built_->contact_of_pair[i]);
    jaw.is_squeezed = built_->world->SmallestGapAlong_m(built_->contact_of_pair[i], direction_W) < 0.0;
  } else {
    // Without planes only the gap at the time of the computation is known. The force must be within 60 degrees of the
    // outward direction (cosine 0.5; judgement).
    jaw.gap_m = set.signed_distance_m;
    const double force_N = glm::length(set.F_So_W.force_N);
    jaw.is_squeezed = set.is_in_contact && force_N > 0.0 && glm::dot(set.F_So_W.force_N, direction_W) > 0.5 * force_N;
  }
  return jaw;
}

void ContactFeed::ExchangeState(physics::Checkpoint* checkpoint) {
  for (Contact& contact : contacts_) checkpoint->Exchange(&contact);
}

}  // namespace physics_node
