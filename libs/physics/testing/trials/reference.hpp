#pragma once

#include "physics/solver_work.hpp"
#include "physics/world.hpp"

// One scene each for a claim of the dynamics; figures out, no judgement.
namespace physics::trials {

// Ten minutes of straight drift at an odd speed: largest error over the way so far.
double DriftError();

// Blocks on a chain of springs that knock together with friction, in free space: what momentum is off at the end, over
// the sum of the magnitudes of all impulses (and their moments about the origin).
struct MomentumResidual {
  double linear = 0.0;
  double angular = 0.0;
  ImpulseBalance joints;
  ImpulseBalance contacts;
  int num_pushes = 0;  // steps in which a pair pushed
};
MomentumResidual MixedContacts(double seconds);

// A block on four feet on a slope of this tangent, friction as given, at 1 g.
struct SlopeFigures {
  double creep_m_per_s = 0.0;          // between 2 and 12 s
  double acceleration_m_per_s2 = 0.0;  // between 1 and 2 s
};
SlopeFigures BlockOnSlope(double tangent, double friction, ContactKind kind);

// A box that bounces on the floor for half a second, and parts that drift far off, each with a pair that could touch
// it: what the solver does.
SolverWork WorkOfAMover(int num_far);

// A press of 2 kg with 10,000 points on the table, reduced at every step, 60 N off its centre, pulled to and fro below
// the limit of friction: what a corner moves along the normal at most, once settled.
double RockingOfAPress_m(double seconds);

}  // namespace physics::trials
