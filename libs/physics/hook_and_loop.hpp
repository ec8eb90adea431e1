#pragma once

#include <vector>

#include "physics/row.hpp"

namespace physics {

// scene::Mechanism of kind hook-and-loop: patches that hold the child to the parent at their initial relative pose.
struct HookAndLoopParams {
  std::vector<glm::dvec3> p_PPatch_m;  // in the parent's mesh frame
  core::Pose X_PC;                     // child in parent when the patches were joined
  double release_force_N = 0.0;        // per patch
  double stiffness_N_per_m = 0.0;      // per patch
  double damping_N_s_per_m = 0.0;
};

// Each patch is an isotropic spring that breaks for good when its force k |offset| exceeds the release force. state and
// position are the number of unbroken patches, force the magnitude of their sum. Tunables: release_force_N,
// stiffness_N_per_m, damping.
class HookAndLoop final : public Mechanism {
 public:
  explicit HookAndLoop(const HookAndLoopParams& params);
  void Prepare(const BodyView& parent, const BodyView& child, double dt_s) override;
  void Finish(double dt_s) override;
  [[nodiscard]] double StoredEnergy_J(const BodyView& parent, const BodyView& child) const override;
  void ExchangeState(Checkpoint* checkpoint) override;

 private:
  HookAndLoopParams params_;
  std::vector<glm::dvec3> p_CPatch_m_;
  std::vector<bool> is_held_;
};

}  // namespace physics
