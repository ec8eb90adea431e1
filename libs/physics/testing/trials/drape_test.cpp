#include "physics/testing/trials/drape.hpp"

#include <gtest/gtest.h>

#include "physics/testing/closed_form/hanging_sheet.hpp"

namespace physics {
namespace {

TEST(Drape, ConvergesToTheElasticaWithTheSquareOfTheCellSize) {
  const double exact_m =
      closed_form::HangingSheetSag_m(0.5 * kDrapeSide_m, kDrapeWeight_N_per_m2, kDrapeBendingStiffness_Nm);
  const double coarse = Drape(8).sag_m / exact_m - 1.0;
  const double fine = Drape(16).sag_m / exact_m - 1.0;
  EXPECT_LT(fine, 0.02);
  EXPECT_GT(fine, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.5);
}

}  // namespace
}  // namespace physics
