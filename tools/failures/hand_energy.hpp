#pragma once

#include "core/messages/device.hpp"
#include "core/wrench.hpp"
#include "scene/scenario.hpp"

namespace failures {

// What passes through a hand device.
//
// Energy that comes back late hides behind what friction has taken before, so it is also judged from one instant
// without a force to any later one. Nothing is stored then; what comes back between the two, beyond what the device's
// own damping takes, was generated.
class HandEnergy {
 public:
  // One tick later: the device as it is now, and the mean wrench that acted on the hand until now.
  void Add(const core::DeviceState& device, const core::Wrench& acted, const scene::Device& parameters);

  // Put in by the hand against the rendered force, and the least that it was since the beginning.
  [[nodiscard]] double energy_J() const { return energy_J_; }
  [[nodiscard]] double least_J() const { return least_J_; }
  // The least of all windows from an instant without a force to another; never positive.
  [[nodiscard]] double least_of_windows_J() const { return least_of_windows_J_; }

 private:
  core::Pose X_WD_;
  core::Twist V_WD_;
  bool has_begun_ = false;
  double energy_J_ = 0.0;
  double least_J_ = 0.0;
  double with_damping_J_ = 0.0;  // and what the device's damping has taken
  double most_J_ = 0.0;          // of it at an instant without a force
  double least_of_windows_J_ = 0.0;
};

}  // namespace failures
