#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace hug {

// The magnetic clutch between an arm and the gripper in the hand. It holds up to a force and a torque, and comes off
// beyond; without current it is open. It closes when hand and arm are near each other.
struct ClutchFigures {
  double holds_N = 120.0;  // assumed: above all that the filter lets through, below what hurts
  double holds_Nm = 15.0;  // assumed likewise
  // Assumed: a hand finds the place without looking, and the start ramp takes up what is between them.
  double closes_within_m = 0.05;
  double closes_within_rad = 0.5;
};

class Clutch {
 public:
  // `is_powered`: whether it shall be closed. F: through the clutch. X_WT: of the hand. True when it came off by force.
  bool Step(const ClutchFigures& figures, bool is_powered, const core::Wrench& F, const core::Pose& X_WD,
            const core::Pose& X_WT) {
    if (!is_powered) {
      is_closed_ = false;
      has_come_off_ = false;
      return false;
    }
    if (is_closed_) {
      has_come_off_ = glm::length(F.force_N) > figures.holds_N || glm::length(F.torque_Nm) > figures.holds_Nm;
      is_closed_ = !has_come_off_;
    } else if (!has_come_off_) {
      is_closed_ =
          glm::distance(X_WD.translation, X_WT.translation) < figures.closes_within_m &&
          glm::length(core::RotationVector(X_WD.rotation * glm::conjugate(X_WT.rotation))) < figures.closes_within_rad;
    }
    return has_come_off_;
  }
  [[nodiscard]] bool is_closed() const { return is_closed_; }

 private:
  bool is_closed_ = false;
  bool has_come_off_ = false;
};

}  // namespace hug
