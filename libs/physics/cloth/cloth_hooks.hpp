#pragma once

#include "physics/row.hpp"

namespace physics {

// A hook-and-loop mechanism that holds a cloth. The cloth has the springs; this mechanism only reports their state to
// readers of the world: state and position are the number of points that hold, force the magnitude of their sum.
class ClothHooks final : public Mechanism {
 public:
  explicit ClothHooks(int num_points) : Mechanism(0) { Set(num_points, 0.0); }
  void Prepare(const BodyView& /*parent*/, const BodyView& /*child*/, double /*dt_s*/) override {}
  void Finish(double /*dt_s*/) override {}
  void Set(int num_held, double force_N) {
    state_ = num_held;
    position_ = num_held;
    force_ = force_N;
  }
};

}  // namespace physics
