#pragma once

#include <algorithm>

namespace device_bridge {

// What bodies have given by sinking in gravity. A hand that lowers a part gets work that no hand has put in: it was in
// the part's height when the run began.
//
// A state is late, so the account leads it by as much as changed in its last steps. Real-time safe.
class ReleasedWeight {
 public:
  // Once per state of physics_node: PhysicsState::weight_J.
  void Update(double weight_J) noexcept {
    if (!has_begun_) start_J_ = before_J_ = weight_J;
    has_begun_ = true;
    constexpr double kLead_ticks = 3.0;  // a state is up to a tick under way, and the grasp's spring is behind the hand
    energy_J_ = start_J_ - weight_J + kLead_ticks * std::max(0.0, before_J_ - weight_J);
    before_J_ = weight_J;
  }
  // Never negative: that a part is lifted is paid for by what lifts it.
  [[nodiscard]] double energy_J() const { return std::max(0.0, energy_J_); }

 private:
  bool has_begun_ = false;
  double start_J_ = 0.0;
  double before_J_ = 0.0;
  double energy_J_ = 0.0;
};

}  // namespace device_bridge
