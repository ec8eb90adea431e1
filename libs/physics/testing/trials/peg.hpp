#pragma once

#include "physics/world.hpp"

namespace physics::trials {

// A peg in two-point contact with a hole, in the plane y = 0: the edge of its tip touches the wall on the -x side, and
// the edge of the mouth touches the peg's +x side, so both bodies carry contact planes. It is inserted by `depth_m` and
// tilted as far as the clearance allows. Loads act at the centre of its tip: F_z into the hole, F_x sideways, a moment.
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

// Whether it slides in from rest, by more than the deflection of compliant contacts.
bool PegSlidesIn(const PegParams& params, double moment_Nm);
// Smallest moment at which it jams, by bisection to a thousandth of the closed form, closed_form::JammingMoment_Nm.
double FindJammingMoment_Nm(const PegParams& params);

}  // namespace physics::trials
