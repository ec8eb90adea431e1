#pragma once

namespace physics::closed_form {

// A sheet that is laid over a thin horizontal wire: how far a free edge hangs below it, `half_m` along the sheet from
// the wire; weight w per area, bending stiffness D per width, no stretch, curved in one direction only. With the slope
// a(s) below the horizontal (Euler's elastica with its own weight),
//   D a'' = -w (L - s) cos a,  a(0) = 0 by symmetry,  a'(L) = 0,  sag = int_0^L sin a ds,
// solved by shooting for a'(0) with steps of the Runge-Kutta method. For small slopes it is w L^4 / (8 D).
double HangingSheetSag_m(double half_m, double weight_N_per_m2, double bending_stiffness_Nm);

}  // namespace physics::closed_form
