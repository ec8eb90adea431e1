#pragma once

namespace physics::closed_form {

// Block on a slope with Coulomb friction: acceleration down the slope, started from rest.
//   0 up to tan(angle) = mu, then g (sin(angle) - mu cos(angle)).
double SlopeAcceleration_m_per_s2(double angle_rad, double friction, double gravity_m_per_s2);

// Speed after over speed before of a mass that meets an undamped spring whose force comes late by `delay`:
//   m x'' = -k x(t - tau).  x = exp(s t), w^2 = k / m: s^2 + w^2 exp(-s tau) = 0, s = i w + w^2 tau / 2 + O(tau^2).
// The contact lasts half a period pi / w, so the ratio is exp(pi w tau / 2). First order in w tau: 1 % off at
// w tau = 0.1 and 4 % at 0.35. A negative delay describes an implicit spring: its force is that of the next step, and
// it loses as much energy.
double DelayedReboundRatio(double stiffness_N_per_m, double mass_kg, double delay_s);

// Peg in a hole in plane two-point contact [Whitney 1982]: the peg (half width r) is in by the depth l, touches the
// mouth on the +x side and, at its tip, the wall on the -x side. It is pushed in with F_z > 0, sideways with F_x, and
// turned with M >= 0 about the centre of its tip in the sense that presses it on those two points. It slides in while
//   M < r F_z (lambda + mu (1 + lambda) F_x / F_z),  lambda = l / (2 r mu),
// and jams beyond, however hard it is pushed in the same direction. Derived for lambda > 1; for lambda <= 1 each
// contact point lies in the other's friction cone and the peg can be wedged, held without any load.
double JammingMoment_Nm(double depth_m, double half_width_m, double friction, double F_x_N, double F_z_N);
bool CanWedge(double depth_m, double half_width_m, double friction);

}  // namespace physics::closed_form
