#pragma once

#include "physics/snap.hpp"

namespace physics::closed_form {

// Work in J that a hand puts into one slow cycle of a snap, in and out again; it ends as heat. With the engage point
// z_e, the release point z_r and the travel s of `SnapAxialForce`:
//   over the bump       F_e (s - z_e) 2 / pi          taken
//   down into the well  k z_e^2 / 2                   given back
//   out of the well     k z_r^2 / 2                   taken
//   down the bump       F_e (s - z_e) (1 - cos(pi (s - z_r) / (s - z_e))) / pi, given back when z_r lies on it
double SnapCycleWork_J(const SnapParams& params);

}  // namespace physics::closed_form
