#include "nodes/device_bridge/tactile/body_poses.hpp"

namespace device_bridge {

BodyPoses::BodyPoses(const scene::Scenario& scenario) : scenario_(scenario) {
  for (const scene::Object& object : scenario.objects) X_WO_.push_back(object.X_WO);
}

void BodyPoses::Update(const Inputs& inputs) noexcept {
  if (inputs.physics != nullptr) {
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object < X_WO_.size()) X_WO_[body.object] = body.X_WO;
    }
  }
  for (std::size_t i = 0; i < X_WO_.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner != scene::Owner::kHand) continue;
    const auto role = static_cast<std::size_t>(object.role);
    if (role >= inputs.proxies.size() || inputs.proxies[role].header.sequence == 0) continue;
    X_WO_[i] = scene::PartPose(object.part, inputs.proxies[role].X_WD, inputs.proxies[role].opening_m);
  }
}

}  // namespace device_bridge
