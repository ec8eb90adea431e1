#pragma once

namespace dynamics {

// A plate falls flat on the floor in Bullet's world with contact stiffness and no damping (its implicit compliant rows
// and its own collision detection), steps of 1 ms: speed after over before; NaN when it does not come back.
double BulletReboundRatio(double mass_kg, double stiffness_N_per_m, double speed_m_per_s);

}  // namespace dynamics
