#pragma once

namespace physics::trials {

enum class ReboundShape {
  kFlat,    // a plate on the floor
  kEdge,    // a box on its edge
  kBall,    // a ball on the floor
  kBalls,   // two free balls off centre
  kVertex,  // a box's corner on a free ball
};
enum class ReboundInput { kWrench, kHard, kPlanes, kPassive };

// A free body hits the floor or another free body; no damping, no friction, exact geometry. The contact data are
// delayed by whole steps of 1 ms and then held, as over a bus.
struct ReboundParams {
  ReboundShape shape = ReboundShape::kFlat;
  ReboundInput input = ReboundInput::kPlanes;
  double mass_kg = 0.2;
  double spin_rad_per_s = 0.0;
  int delay_ms = 0;
  double stiffness_N_per_m = 1e4;
  double speed_m_per_s = 0.1;
};

// sqrt(E_after / E_before) of the total kinetic energy, once the bodies have separated; NaN when they have not touched
// or not separated.
double ReboundRatio(const ReboundParams& params);

}  // namespace physics::trials
