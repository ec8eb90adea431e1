#pragma once

#include <vector>

#include "core/pose.hpp"
#include "nodes/device_bridge/ports.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// Where each object is, of the newest messages. Parts of a hand: where the device has them, as contact planes are
// meant.
class BodyPoses {
 public:
  explicit BodyPoses(const scene::Scenario& scenario);

  void Update(const Inputs& inputs) noexcept;
  [[nodiscard]] const core::Pose& X_WO(std::size_t object) const { return X_WO_[object]; }

 private:
  const scene::Scenario& scenario_;
  std::vector<core::Pose> X_WO_;  // per object
};

}  // namespace device_bridge
