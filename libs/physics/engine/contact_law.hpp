#pragma once

#include <glm/glm.hpp>

#include "physics/contact_kind.hpp"

namespace physics {

// Law of one contact plane for one step, along its normal. Speeds are dg/dt of its gap g; forces push S outwards.
struct ContactLaw {
  double gap_m = 0.0;                          // g0, at the start of the step; negative inside
  double stiffness_N_per_m = 0.0;              // k of this plane
  double damping_N_s_per_m = 0.0;              // d of this plane, 0 while it is apart
  double pair_stiffness_N_per_m = 0.0;         // sum over the pair's penetrating planes
  ContactKind kind = ContactKind::kCompliant;  // hard: no spring, but a condition on the speed at the end of the step
  glm::dvec3 friction_W_Ns{0.0};               // impulse on S of the last step, for the warm start
  glm::dvec3 slip_W_m{0.0};                    // elastic: of S along the plane, from where it sticks
};

// Tangent of a force law at a speed: F(v) = force - slope (v - speed), slope >= 0.
struct ForceLine {
  double force_N = 0.0;
  double slope_N_s_per_m = 0.0;
};

// Force of a compliant plane over a step dt that starts with speed v0 and ends with speed v1; g1 = g0 + dt v1.
//
// Energy. The step is symplectic: the speed v is half a step earlier than the gap g, so the gaps
//   a = g0 - dt v0 / 2,   b = a + dt (v0 + v1) / 2 = g0 + dt v1 / 2
// belong to v0 and v1. The work of the force is F dt (v0 + v1) / 2 = F (b - a). With the potential
// V(g) = k min(g, 0)^2 / 2 and the discrete gradient [Gonzalez 1996]
//   F = -(V(b) - V(a)) / (b - a)
// kinetic energy plus V is the same before and after every step, including those in which contact begins or ends.
// During contact F = -k (a + b) / 2 = -k (g0 + dt (v1 - v0) / 4): Newmark's rule with beta = 1/4, stable for every k
// dt^2 / m.
//
// Stiff contact. With s = k dt^2 W, W the inverse effective mass of the row and k the pair's stiffness, a contact lasts
// pi / sqrt(s) steps. Beyond s = 1/2 that is too short to resolve it, and a lossless law would ring from step to step.
// From s = 1/2 to s = 2 the force blends into the implicit spring -k (g0 + dt v1), which dissipates what it cannot
// resolve, and which already acts when the motion of this step closes a gap.
//
// Damping is -d v1. The total force is never negative (no adhesion).
ForceLine CompliantForce(const ContactLaw& law, double inverse_mass_per_kg, double v0, double v1, double dt_s);

// Share of the implicit spring in the force above, clamp((s - 1/2) / (2 - 1/2), 0, 1).
double ImplicitShare(double pair_stiffness_N_per_m, double inverse_mass_per_kg, double dt_s);

// Smallest normal speed of a hard contact at the end of the step: -g / dt for a gap g > 0, so that the bodies at most
// touch; for an overlap min(-0.2 g / dt, 20 mm/s), since bodies that are pushed out keep that speed.
double HardSpeed_m_per_s(double gap_m, double dt_s);

}  // namespace physics
