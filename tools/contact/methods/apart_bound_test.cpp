#include "tools/contact/methods/apart_bound.hpp"

#include <gtest/gtest.h>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/random.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// From touching to far apart, at random attitudes: never above the true distance, and within a hundredth of it.
TEST(ApartBound, IsNeverAboveTheTrueDistanceAndCloseToIt) {
  const vps::TriangleMesh torus = vps::MakeTorus(0.03, 0.012, 32, 16);
  const vps::TriangleMesh box = vps::MakeBox({0.03, 0.02, 0.04});
  const vps::TriangleMesh hole = vps::MakeBlockWithHole(0.06, 0.04, 0.01, 24);
  const vps::TriangleMesh peg = vps::MakeCylinder(8e-3, 0.06, 200);  // of thin triangles
  Random random(3);
  for (const auto& [A, B] : {std::pair{&torus, &box}, {&box, &torus}, {&hole, &box}, {&hole, &torus}, {&peg, &hole}}) {
    ApartBound bound(*A, *B);
    const vps::oracle::MeshDistance exact_A(*A);
    const vps::oracle::MeshDistance exact_B(*B);
    int num_apart = 0;
    for (int i = 0; i < 60; ++i) {
      const core::Pose X{random.Rotation(), random.Uniform(0.03, 0.07) * random.Direction()};
      const double truth_m = vps::oracle::SurfaceDistance(exact_A, exact_B, X);
      const double bound_m = bound.Query_m(X);
      ASSERT_LE(bound_m, truth_m) << i;
      EXPECT_GE(bound_m, (1.0 - 2.0 * ApartBound::kTolerance) * truth_m) << i;
      num_apart += truth_m > 0.0 ? 1 : 0;
    }
    EXPECT_GT(num_apart, 10);
    EXPECT_LT(num_apart, 60);  // where they meet the bound is 0
  }
}

// From a metre's hundredth to a micrometre, whatever was nearest before.
TEST(ApartBound, HoldsForParallelFacesWhateverWasAskedBefore) {
  const vps::TriangleMesh box = vps::MakeBox({0.03, 0.02, 0.04});
  ApartBound bound(box, box);
  for (const double gap_m : {1e-2, 1e-5, 1e-3, 1e-6}) {
    const double above_m = bound.Query_m({{1, 0, 0, 0}, {0.005, 0.002, 0.04 + gap_m}});
    EXPECT_LE(above_m, gap_m);
    EXPECT_GE(above_m, 0.98 * gap_m);
    EXPECT_EQ(bound.Query_m({{1, 0, 0, 0}, {0.005, 0.002, 0.039}}), 0.0);
    const double beside_m = bound.Query_m({{1, 0, 0, 0}, {-0.03 - gap_m, 0.002, 0.01}});
    EXPECT_LE(beside_m, gap_m);
    EXPECT_GE(beside_m, 0.98 * gap_m);
  }
}

TEST(ApartBound, IsTheDistanceThatFastAnswersWhenApart) {
  const vps::TriangleMesh box = vps::MakeBox({0.03, 0.02, 0.04});
  const auto method = MakeFastMethod(box, box, {1e-3, 8192});
  ASSERT_TRUE(method);
  const Answer answer = (*method)->Query({{1, 0, 0, 0}, {0.0, 0.0, 0.0405}});
  EXPECT_EQ(answer.contacts, 0U);
  EXPECT_NEAR(answer.signed_distance_m, 5e-4, 5e-6);
}

}  // namespace
}  // namespace contact
