#include "physics/testing/closed_form/hanging_sheet.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics::closed_form {
namespace {

TEST(HangingSheet, BendsLikeAClampedBeamWhereItIsStiff) {
  const double sag = HangingSheetSag_m(0.1, 2.0, 0.05);
  EXPECT_NEAR(sag / (2.0 * std::pow(0.1, 4) / (8.0 * 0.05)), 1.0, 1e-4);
}

TEST(HangingSheet, HangsLowerWithLessStiffnessAndNeverBelowItsLength) {
  double before = 0.0;
  for (const double bending : {1e-1, 1e-3, 1e-4, 1e-5}) {
    const double sag = HangingSheetSag_m(0.1, 1.0, bending);
    EXPECT_GT(sag, before) << bending;
    EXPECT_LT(sag, 0.1) << bending;
    before = sag;
  }
  EXPECT_GT(before, 0.085);  // the bend shortens it by about (D / w L^3)^(1/2) of its length at most
}

}  // namespace
}  // namespace physics::closed_form
