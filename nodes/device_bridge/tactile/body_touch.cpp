#include "nodes/device_bridge/tactile/body_touch.hpp"

#include <algorithm>

namespace device_bridge {

BodyTouch::BodyTouch(const scene::Scenario& scenario, const scene::Tactile& tactile)
    : tactile_(tactile), sense_(scenario.pairs.size()) {
  for (std::size_t i = 0; i < scenario.pairs.size(); ++i) {
    const scene::Pair& pair = scenario.pairs[i];
    if (pair.sampled == tactile.body || pair.field == tactile.body) pairs_.push_back(i);
  }
}

void BodyTouch::Step(std::int64_t now_ns, std::span<const SeenContacts> contacts, const BodyPoses& poses) noexcept {
  tactile::TouchSum sum;
  const core::Pose X_WB = poses.X_WO(static_cast<std::size_t>(tactile_.body)) * tactile_.X_OB;
  sense_.Begin(now_ns, X_WB);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SeenContacts& seen = contacts[i];
    if (seen.set == nullptr || now_ns - seen.received_ns > kContactAge_ns) continue;
    const core::ContactSet& set = *seen.set;
    const bool is_sampled = set.sampled_body == tactile_.body;
    const core::Pose &X_WS = poses.X_WO(set.sampled_body), &X_WG = poses.X_WO(set.field_body);
    sum.Add(set, X_WS, X_WG, is_sampled);
    sense_.Add(i, set, X_WS, X_WG, is_sampled);
  }
  touch_ = sum.touch();
  finger_ = sense_.End();
  towards_B_ = glm::conjugate(X_WB.rotation) * touch_.towards_W;
  const bool is_by_force = tactile_.full_force_N > 0.0;
  const double share = is_by_force ? touch_.force_N / tactile_.full_force_N : touch_.depth_m / tactile_.full_depth_m;
  strength_ = std::clamp(share, 0.0, 1.0);
}

}  // namespace device_bridge
