#include "physics/testing/closed_form/snap_work.hpp"

#include <gtest/gtest.h>

namespace physics::closed_form {
namespace {

// Work over the profile by the midpoint rule with steps of 0.1 um.
double SummedWork_J(const SnapParams& p) {
  constexpr double kStep = 1e-7;
  double work = 0.0;
  bool is_engaged = false;
  const int top = static_cast<int>(2.0 * (p.travel_m + SnapReleasePoint_m(p)) / kStep);
  for (int i = top; i > 0; --i) {
    is_engaged = is_engaged || (i - 0.5) * kStep <= SnapEngagePoint_m(p);
    work += SnapAxialForce(p, is_engaged, (i - 0.5) * kStep).force_N * kStep;
  }
  for (int i = 0; i < top; ++i) {
    is_engaged = is_engaged && (i + 0.5) * kStep <= SnapReleasePoint_m(p);
    work -= SnapAxialForce(p, is_engaged, (i + 0.5) * kStep).force_N * kStep;
  }
  return work;
}

TEST(SnapWork, EqualsTheIntegralOverTheProfile) {
  for (const double release_N : {5.0, 20.0, 45.0, 100.0}) {
    SnapParams p;
    p.engage_force_N = 15.0;
    p.release_force_N = release_N;
    EXPECT_NEAR(SnapCycleWork_J(p), SummedWork_J(p), 1e-4 * SnapCycleWork_J(p)) << release_N;
    EXPECT_GT(SnapCycleWork_J(p), 0.0);
  }
}

TEST(SnapWork, WithoutABumpEqualsTheDifferenceOfTheWells) {
  SnapParams p;
  p.engage_force_N = 0.0;
  p.release_force_N = 20.0;
  const double z_r = 20.0 / 2.0e4;
  EXPECT_NEAR(SnapCycleWork_J(p), 0.5 * 2.0e4 * (z_r * z_r - 0.25 * z_r * z_r), 1e-15);
}

}  // namespace
}  // namespace physics::closed_form
