#include "physics/testing/closed_form/snap_work.hpp"

#include <cmath>
#include <numbers>

namespace physics::closed_form {

double SnapCycleWork_J(const SnapParams& params) {
  const double z_e = SnapEngagePoint_m(params);
  const double z_r = SnapReleasePoint_m(params);
  const double width = params.travel_m - z_e;
  const double scale_J = params.engage_force_N * width / std::numbers::pi;
  const double in_J = 2.0 * scale_J - 0.5 * params.stiffness_N_per_m * z_e * z_e;
  const double back_J =
      z_r >= params.travel_m ? 0.0 : scale_J * (1.0 - std::cos(std::numbers::pi * (params.travel_m - z_r) / width));
  return in_J + 0.5 * params.stiffness_N_per_m * z_r * z_r - back_J;
}

}  // namespace physics::closed_form
