#pragma once

#include <glm/glm.hpp>

namespace physics {

// What one contact plane asks of one step, along its normal; speeds are dg/dt of its gap g, forces push S out.
struct ContactLaw {
  double gap_m = 0.0;                   // g0, at the start of the step; negative inside
  double stiffness_N_per_m = 0.0;       // k of this plane
  double damping_N_s_per_m = 0.0;       // d of this plane, 0 while it is apart
  double pair_stiffness_N_per_m = 0.0;  // of the planes that push together
  bool is_hard = false;                 // no spring: what speed must be met at the end of the step
  glm::dvec3 friction_W_Ns{0.0};        // impulse on S of the last step, to start from
};

// A straight line through a force law: F(v) = force - slope (v - speed), slope >= 0.
struct ForceLine {
  double force_N = 0.0;
  double slope_N_s_per_m = 0.0;
};

// Force of a compliant plane over a step dt that starts with speed v0 and ends with speed v1; g1 = g0 + dt v1.
//
// Energy. The step is symplectic: v is known half a step before g, so that half way between two gaps
//   a = g0 - dt v0 / 2,   b = a + dt (v0 + v1) / 2 = g0 + dt v1 / 2
// are the gaps that belong to v0 and v1. The force's work is F dt (v0 + v1) / 2 = F (b - a). With the potential
// V(g) = k min(g, 0)^2 / 2 and the discrete gradient
//   F = -(V(b) - V(a)) / (b - a)
// kinetic energy plus V is the same before and after, for every step, also those in which contact begins or ends. While
// it lasts F = -k (a + b) / 2 = -k (g0 + dt (v1 - v0) / 4): Newmark's rule with beta 1/4, stable for every k dt^2 / m.
// (Gonzalez 1996 for the discrete gradient.)
//
// Stiff. With s = k dt^2 W, W the inverse effective mass of the row and k the pair's, a contact lasts pi / sqrt(s)
// steps. Beyond s = 1/2 it is too short to be resolved, and ringing from step to step is what a lossless law would
// give. From there to s = 2 the force goes over continuously to the implicit spring -k (g0 + dt v1), which loses
// what it cannot resolve, and pushes already as much as the motion of this step goes beyond a gap.
//
// Damping is -d v1. The whole never pulls.
ForceLine CompliantForce(const ContactLaw& law, double inverse_mass_per_kg, double v0, double v1, double dt_s);

// Share of the implicit spring above, 0 to 1.
double ImplicitShare(double pair_stiffness_N_per_m, double inverse_mass_per_kg, double dt_s);

// Speed at which a hard contact may approach at most: to touch at the end of the step when it is apart, to part slowly
// when it overlaps (a fifth of the overlap per step, up to 20 mm/s: what is pushed out stays in motion).
double HardSpeed_m_per_s(double gap_m, double dt_s);

}  // namespace physics
