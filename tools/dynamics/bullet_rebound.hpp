#pragma once

namespace dynamics {

// A plate falls flat on the floor in Bullet's world, with Bullet's implicit compliant rows (contact stiffness, no
// damping), its own collision detection and steps of 1 ms. Returns speed after over speed before; NaN without rebound.
double BulletReboundRatio(double mass_kg, double stiffness_N_per_m, double speed_m_per_s);

}  // namespace dynamics
