#pragma once

#include <cstdint>
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
  double softness = 0.0;                       // hard: compliance relative to the row's inverse mass
  double paid_share = 1.0;                     // of what the springs hold, that work has put into them
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
// Springs that were not loaded by work. Bodies may be put into each other, and planes that are found anew may be deeper
// or stiffer than those before, so the springs hold V though only E has been put in. The share E / V of the force is as
// above and gives back E at most. The rest holds the bodies apart, but it pushes no faster than hard contacts part.
//
// The force over v1 has three pieces then: the whole spring, its rest against the stop at that speed, and the paid part
// alone. Newton's method would go to and fro between the first and the last; so with `piece`, where the row was, it
// goes to the next one only, and the line is that of the piece.
//
// Damping is -d v1. The total force is never negative (no adhesion).
enum class UnpaidPiece : std::uint8_t { kPushes, kIsStopped, kIsLeftOut };
ForceLine CompliantForce(const ContactLaw& law, double inverse_mass_per_kg, double v0, double v1, double dt_s,
                         UnpaidPiece* piece = nullptr);

// V of a plane with gap g.
double SpringEnergy_J(double stiffness_N_per_m, double gap_m);

// Share of the implicit spring in the force above, clamp((s - 1/2) / (2 - 1/2), 0, 1).
double ImplicitShare(double pair_stiffness_N_per_m, double inverse_mass_per_kg, double dt_s);

// Smallest normal speed of a hard contact at the end of the step: -g / dt for a gap g > 0, so that the bodies at most
// touch; for an overlap min(-0.2 g / dt, 20 mm/s), since bodies that are pushed out keep that speed.
double HardSpeed_m_per_s(double gap_m, double dt_s);

// Share of the speed that a hard contact should change and leaves, by the force that it exerts: contacts that
// contradict each other get a bounded force by it.
double HardSoftness(bool is_of_hand);

}  // namespace physics
