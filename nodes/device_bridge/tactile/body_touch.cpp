#include "nodes/device_bridge/tactile/body_touch.hpp"

#include <algorithm>

namespace device_bridge {

BodyTouch::BodyTouch(const scene::Scenario& scenario, const scene::Tactile& tactile) : tactile_(tactile) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const scene::Pair& pair = scenario.pairs[i];
    if (pair.sampled == tactile.body || pair.field == tactile.body) pairs_.push_back(i);
  }
}

void BodyTouch::Step(std::int64_t now_ns, std::span<const SeenContacts> contacts, const BodyPoses& poses) noexcept {
  tactile::TouchSum sum;
  for (const SeenContacts& seen : contacts) {
    if (seen.set == nullptr || now_ns - seen.received_ns > kContactAge_ns) continue;
    const core::ContactSet& set = *seen.set;
    sum.Add(set, poses.X_WO(set.sampled_body), poses.X_WO(set.field_body), set.sampled_body == tactile_.body);
  }
  touch_ = sum.touch();
  const core::Pose X_WB = poses.X_WO(static_cast<std::size_t>(tactile_.body)) * tactile_.X_OB;
  towards_B_ = glm::conjugate(X_WB.rotation) * touch_.towards_W;
  const bool is_by_force = tactile_.full_force_N > 0.0;
  const double share = is_by_force ? touch_.force_N / tactile_.full_force_N : touch_.depth_m / tactile_.full_depth_m;
  strength_ = std::clamp(share, 0.0, 1.0);
}

}  // namespace device_bridge
