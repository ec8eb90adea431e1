#pragma once

#include "physics/row.hpp"

namespace physics {

// A hook-and-loop mechanism that holds a cloth: the cloth has the springs, this tells a world's readers how they are.
// state and position are the points that still hold, force the magnitude of their sum.
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
