#include "physics/testing/trials/peg.hpp"

#include <gtest/gtest.h>

#include "physics/testing/closed_form/contact_laws.hpp"

namespace physics::trials {
namespace {

// Both bodies carry planes, friction is at its limit: the jamming moment equals that of Whitney's theory.
TEST(Peg, TightFitJamsWhereTheoryPredicts) {
  for (const double friction : {0.1, 0.25}) {
    for (const double depth_m : {0.015, 0.05}) {
      for (const double side_N : {0.0, 1.0}) {
        PegParams params;
        params.clearance_m = 5e-6;
        params.friction = friction;
        params.depth_m = depth_m;
        params.F_x_N = side_N;
        const double exact_Nm =
            closed_form::JammingMoment_Nm(depth_m, params.half_width_m, friction, side_N, params.F_z_N);
        EXPECT_NEAR(FindJammingMoment_Nm(params) / exact_Nm, 1.0, 0.005) << friction << " " << depth_m << " " << side_N;
      }
    }
  }
}

}  // namespace
}  // namespace physics::trials
