#pragma once

#include <optional>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

// Where a device's base B stands in W.
//
// Calibrated, X_WB is known, and X_WD = X_WB X_BD. Otherwise B's axes are taken to be W's, and the hand goes on from
// where it was whenever the device is taken up anew (the dead-man is a clutch):
//   p_WD = p_WD0 + (p_BD - p_BD0),   R_WD = R_BD R_BD0^-1 R_WD0.
class FrameMap {
 public:
  explicit FrameMap(const core::Pose& X_WD_start) : X_WD_(X_WD_start) {}

  void SetCalibration(const std::optional<core::Pose>& X_WB) {
    is_calibrated_ = X_WB.has_value();
    R_WB_ = X_WB ? X_WB->rotation : glm::dquat(1, 0, 0, 0);
    p_WB_ = X_WB ? X_WB->translation : glm::dvec3(0.0);
    R_DDw_ = glm::dquat(1, 0, 0, 0);
  }
  // Before the first Map after the device was let go.
  void TakeUp(const core::Pose& X_BD) {
    if (is_calibrated_) return;
    p_WB_ = X_WD_.translation - X_BD.translation;
    R_DDw_ = glm::conjugate(X_BD.rotation) * X_WD_.rotation;
  }
  const core::Pose& Map(const core::Pose& X_BD) {
    X_WD_.rotation = glm::normalize(R_WB_ * X_BD.rotation * R_DDw_);
    X_WD_.translation = R_WB_ * X_BD.translation + p_WB_;
    return X_WD_;
  }
  [[nodiscard]] core::Twist Map(const core::Twist& V_BD) const {
    core::Twist twist;
    twist.angular_rad_per_s = R_WB_ * V_BD.angular_rad_per_s;
    twist.linear_m_per_s = R_WB_ * V_BD.linear_m_per_s;
    return twist;
  }
  [[nodiscard]] core::Wrench ToBase(const core::Wrench& F_Do_W) const {
    const glm::dquat R_BW = glm::conjugate(R_WB_);
    return {R_BW * F_Do_W.force_N, R_BW * F_Do_W.torque_Nm};
  }
  [[nodiscard]] core::Wrench Map(const core::Wrench& F_Do_B) const {
    return {R_WB_ * F_Do_B.force_N, R_WB_ * F_Do_B.torque_Nm};
  }
  // Where the device would have its hand frame if D stood there.
  [[nodiscard]] core::Pose ToBase(const core::Pose& X_WG) const {
    const glm::dquat R_BW = glm::conjugate(R_WB_);
    return {glm::normalize(R_BW * X_WG.rotation * glm::conjugate(R_DDw_)), R_BW * (X_WG.translation - p_WB_)};
  }
  [[nodiscard]] core::Pose X_WB() const { return {R_WB_, p_WB_}; }
  [[nodiscard]] const core::Pose& X_WD() const { return X_WD_; }  // of the latest Map
  [[nodiscard]] bool is_calibrated() const { return is_calibrated_; }

 private:
  bool is_calibrated_ = false;
  glm::dquat R_WB_{1, 0, 0, 0};
  glm::dvec3 p_WB_{0.0};
  glm::dquat R_DDw_{1, 0, 0, 0};  // from the hand's frame in W to the device's own
  core::Pose X_WD_;
};

}  // namespace device_bridge
