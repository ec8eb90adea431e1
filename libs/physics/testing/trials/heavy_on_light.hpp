#pragma once

#include "physics/world.hpp"

namespace physics::trials {

// A heavy block on a block of 0.2 kg on the ground, each on four corners with friction, under their weight at 1 g from
// the first step on. The contact stiffness of 1e12 N/m deflects by nanometres, so that larger overlap is the
// solver's residual.
class HeavyOnLight {
 public:
  static constexpr double kLight_kg = 0.2;
  static constexpr double kSide_m = 0.1;

  HeavyOnLight(double ratio, ContactKind kind);
  void Step();
  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] double deepest_m() const { return deepest_m_; }  // largest overlap of any pair so far
  // The ground's force on the light block over the weight of both blocks; 1 when they rest.
  [[nodiscard]] double ForceRatio() const;

 private:
  World world_;
  int lower_ = -1;
  int upper_ = -1;
  double weight_N_ = 0.0;
  double deepest_m_ = 0.0;
};

}  // namespace physics::trials
