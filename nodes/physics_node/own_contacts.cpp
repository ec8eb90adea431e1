#include "nodes/physics_node/own_contacts.hpp"

#include <algorithm>
#include <utility>

namespace physics_node {

core::Result<std::unique_ptr<OwnContacts>> OwnContacts::Create(const scene::Scenario& scenario,
                                                               core::ParallelFor& workers,
                                                               const collision::Options& options) {
  auto owned = collision::BuildOwnedWorld(scenario, scene::PairOwner::kPhysics, workers, options);
  if (!owned) return core::Fail(owned.error().code, owned.error().detail);
  return std::unique_ptr<OwnContacts>(new OwnContacts(std::move(*owned), workers));
}

OwnContacts::OwnContacts(collision::OwnedWorld owned, core::ParallelFor& workers)
    : owned_(std::move(owned)), workers_(workers), pairs_(owned_.scenario_pair.size()) {}

void OwnContacts::Step(std::uint64_t tick, std::int64_t now_ns) {
  report_ = owned_.world->Step(&workers_);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Pair& pair = pairs_[i];
    const auto scenario_pair = owned_.scenario_pair[i];
    pair.is_published = collision::FillContactUpdate(*owned_.world, i, scenario_pair, &pair.empty_sets_left, &pair.set);
    pair.is_near = pair.is_published && !pair.set.planes.empty();
    if (!pair.is_published) continue;
    pair.set.cycle = tick;
    pair.set.header.sequence = tick;
    pair.set.header.publish_ns = now_ns;
  }
}

std::size_t OwnContacts::IndexOf(std::size_t scenario_pair) const {
  const auto& pairs = owned_.scenario_pair;
  return static_cast<std::size_t>(std::find(pairs.begin(), pairs.end(), scenario_pair) - pairs.begin());
}

void OwnContacts::SetActive(std::size_t scenario_pair, bool is_active) {
  if (const std::size_t i = IndexOf(scenario_pair); i < pairs_.size()) owned_.world->SetActive(i, is_active);
}

// Springs of stiffness k at the gaps g_i < 0 store E = sum_i k_i g_i^2 / 2 [J]; scaling all k_i by k'/k adds E (k'/k -
// 1).
double OwnContacts::SetStiffness(std::size_t scenario_pair, double stiffness_N_per_m, const core::Pose& X_WS,
                                 const core::Pose& X_WG) {
  const std::size_t i = IndexOf(scenario_pair);
  if (i == pairs_.size()) return 0.0;
  double stored_J = 0.0;
  if (pairs_[i].is_near) {
    for (const core::ContactPlane& plane : pairs_[i].set.planes) {
      const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
      const double gap_m = glm::dot(n_W, X_WS * glm::dvec3(plane.p_S) - X_WG * glm::dvec3(plane.q_G));
      if (gap_m < 0.0) stored_J += 0.5 * plane.stiffness_N_per_m * gap_m * gap_m;
    }
  }
  const double before_N_per_m = owned_.world->pair(i).stiffness_N_per_m;
  owned_.world->SetStiffness(i, stiffness_N_per_m);
  return stored_J * (stiffness_N_per_m / before_N_per_m - 1.0);
}

void OwnContacts::ExchangeState(physics::Checkpoint* checkpoint) {
  for (std::size_t object = 0; object < owned_.world->num_objects(); ++object) {
    core::Pose X_WO = owned_.world->X_WO(object);
    checkpoint->Exchange(&X_WO);
    if (checkpoint->is_reading()) owned_.world->SetPose(object, X_WO);
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    bool is_active = owned_.world->is_active(i);
    double stiffness_N_per_m = owned_.world->pair(i).stiffness_N_per_m;
    checkpoint->Exchange(&is_active);
    checkpoint->Exchange(&stiffness_N_per_m);
    checkpoint->Exchange(&pairs_[i].empty_sets_left);
    owned_.world->SetActive(i, is_active);
    if (stiffness_N_per_m != owned_.world->pair(i).stiffness_N_per_m) owned_.world->SetStiffness(i, stiffness_N_per_m);
    vps::PairMemory memory = owned_.world->Memory(i);
    checkpoint->Exchange(&memory);
    if (checkpoint->is_reading()) owned_.world->Continue(i, memory);
  }
}

}  // namespace physics_node
