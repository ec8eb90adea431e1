#pragma once

#include <memory>
#include <vector>

#include "collision/owned_world.hpp"
#include "core/messages/haptic.hpp"
#include "physics/checkpoint.hpp"

namespace physics_node {

// Contacts that physics_node computes itself (pairs with owner="physics"), by the same code as haptic_node. The planes
// are computed at the poses of the start of the tick in which they act, so there is no delay.
class OwnContacts {
 public:
  // `workers` must outlive it. Without such pairs nothing is cooked, and Step does nothing.
  static core::Result<std::unique_ptr<OwnContacts>> Create(const scene::Scenario& scenario, core::ParallelFor& workers,
                                                           const collision::Options& options);

  void SetPose(std::size_t object, const core::Pose& X_WO) { owned_.world->SetPose(object, X_WO); }
  // Tests every pair that is due, without a time limit, so that results do not depend on the speed of the machine.
  void Step(std::uint64_t tick, std::int64_t now_ns);
  [[nodiscard]] const vps::StepReport& report() const { return report_; }  // work of the last step

  [[nodiscard]] std::size_t num_pairs() const { return pairs_.size(); }
  [[nodiscard]] std::size_t scenario_pair(std::size_t pair) const { return owned_.scenario_pair[pair]; }
  [[nodiscard]] const core::ContactSet& set(std::size_t pair) const { return pairs_[pair].set; }
  core::ContactSet& set(std::size_t pair) { return pairs_[pair].set; }  // sending stamps its header
  // The pair's set of the last step is to be sent to other nodes.
  [[nodiscard]] bool is_published(std::size_t pair) const { return pairs_[pair].is_published; }
  // The pair's set belongs to the poses of the last step; otherwise the pair is apart and its set is outdated.
  [[nodiscard]] bool is_near(std::size_t pair) const { return pairs_[pair].is_near; }
  [[nodiscard]] double force_error_N(std::size_t pair) const { return owned_.world->result(pair).force_error_N; }

  // By scenario pair; no effect for pairs of other nodes.
  void SetActive(std::size_t scenario_pair, bool is_active);
  // Returns the injected energy [J]: the change of sum(k gap^2 / 2) over the penetrating planes at these poses.
  double SetStiffness(std::size_t scenario_pair, double stiffness_N_per_m, const core::Pose& X_WS,
                      const core::Pose& X_WG);

  // Saves or restores the changed parameters and what pairs keep from tick to tick.
  void ExchangeState(physics::Checkpoint* checkpoint);

 private:
  struct Pair {
    core::ContactSet set;
    int empty_sets_left = 0;
    bool is_published = false;
    bool is_near = false;
  };

  OwnContacts(collision::OwnedWorld owned, core::ParallelFor& workers);
  [[nodiscard]] std::size_t IndexOf(std::size_t scenario_pair) const;

  collision::OwnedWorld owned_;
  core::ParallelFor& workers_;
  std::vector<Pair> pairs_;
  vps::StepReport report_;
};

}  // namespace physics_node
