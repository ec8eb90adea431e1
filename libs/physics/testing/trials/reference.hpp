#pragma once

#include "physics/solver_work.hpp"
#include "physics/world.hpp"

// One scene for each claim about the dynamics. They return figures; their callers compare them with limits.
namespace physics::trials {

// Ten minutes of straight drift: largest position error, relative to the distance travelled.
double DriftError();

// Blocks on a chain of springs that collide with friction, in free space: the error of the total momentum at the end,
// relative to the sum of the magnitudes of all impulses (of their moments about the origin for angular momentum).
struct MomentumResidual {
  double linear = 0.0;
  double angular = 0.0;
  ImpulseBalance joints;
  ImpulseBalance contacts;
  int num_pushes = 0;  // pairs with a contact force, summed over the steps
};
MomentumResidual MixedContacts(double seconds);

// A block on four feet at 1 g on a slope with this tangent and this friction coefficient.
struct SlopeFigures {
  double creep_m_per_s = 0.0;          // between 2 and 12 s
  double acceleration_m_per_s2 = 0.0;  // between 1 and 2 s
};
SlopeFigures BlockOnSlope(double tangent, double friction, ContactKind kind);

// The solver's work for a box that bounces on the floor for half a second, while `num_far` distant parts drift, each
// with a contact pair to the box but no contact.
SolverWork WorkOfAMover(int num_far);

// A plate of 2 kg, pressed on the table with 60 N off its centre and pulled to and fro below the friction limit, with
// 10,000 contact points reduced at every step: largest range of a corner's motion along the normal, once settled.
double RockingOfAPress_m(double seconds);

}  // namespace physics::trials
