#pragma once

#include "physics/world.hpp"

namespace physics::trials {

// A peg in two-point contact with a hole, in the plane y = 0: its tip's edge at the wall on the -x side, the mouth's
// edge at its +x side, so planes are carried by both bodies. It is in by `depth_m` and tilted by what the clearance
// allows. A force F_z into the hole, F_x aside and a moment push it, all about the centre of its tip.
struct PegParams {
  double depth_m = 0.03;
  double half_width_m = 0.01;
  double clearance_m = 1e-5;  // on each side
  double friction = 0.25;
  double F_x_N = 0.0;
  double F_z_N = 5.0;
  ContactKind kind = ContactKind::kHard;
  double stiffness_N_per_m = 2e4;  // of the pair, when compliant
};

// Whether it goes in, from rest, by more than what compliant contacts give way.
bool PegSlidesIn(const PegParams& params, double moment_Nm);
// Moment above which it jams, by bisection to a thousandth; the closed form is closed_form::JammingMoment_Nm.
double FindJammingMoment_Nm(const PegParams& params);

}  // namespace physics::trials
