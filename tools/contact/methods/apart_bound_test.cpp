#include "tools/contact/methods/apart_bound.hpp"

#include <gtest/gtest.h>

#include "tools/contact/methods/method.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"

namespace contact {
namespace {

// From touching to far apart, at random attitudes: never above the true distance, and within a hundredth of it.
TEST(ApartBound, IsNeverAboveTheTrueDistanceAndCloseToIt) {
  const vps::TriangleMesh torus = vps::MakeTorus(0.03, 0.012, 32, 16);
  const vps::TriangleMesh box = vps::MakeBox({0.03, 0.02, 0.04});
  const vps::TriangleMesh hole = vps::MakeBlockWithHole(0.06, 0.04, 0.01, 24);
  const vps::TriangleMesh peg = vps::MakeCylinder(8e-3, 0.06, 200);  // of thin triangles
  vps::CaseRandom random(3);
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

// 0.05 mm of clearance all around: every strip of one is near a few of the other.
class FreePeg : public testing::Test {
 protected:
  const vps::TriangleMesh hole = vps::MakeBlockWithHole(0.06, 0.04, 0.01005, 256);
  const vps::TriangleMesh peg = vps::MakeCylinder(0.01, 0.06, 256);
  static core::Pose At(double aside_m, double tilt) {
    return {core::QuaternionFromRotationVector({tilt, 0.0, 0.0}) * core::QuaternionFromRotationVector({0.0, 0.0, 0.3}),
            {aside_m, 0.0, 5e-3}};
  }
};

TEST_F(FreePeg, IsBoundedCloselyWithinItsClearance) {
  ApartBound bound(hole, peg);
  const vps::oracle::MeshDistance exact_hole(hole);
  const vps::oracle::MeshDistance exact_peg(peg);
  const auto share_of = [&](const core::Pose& X) {
    const double truth_m = vps::oracle::SurfaceDistance(exact_hole, exact_peg, X);
    const double bound_m = bound.Query_m(X);
    EXPECT_LE(bound_m, truth_m);
    return bound_m / truth_m;
  };
  for (const core::Pose& X : {At(2e-5, 0.0), At(0.0, 1e-3), At(1.5e-5, -1e-3)}) {
    EXPECT_GE(share_of(X), 1.0 - 2.0 * ApartBound::kTolerance);
  }
  // In the middle all around is as near: the pairs run out before.
  EXPECT_GE(share_of(At(0.0, 0.0)), 0.8);
}

TEST_F(FreePeg, HasNoContactToIntegrate) {
  const auto method = MakeFastMethod(hole, peg, {5e-4, 16384});
  ASSERT_TRUE(method);
  const Answer free = (*method)->Query(At(2e-5, 0.0));
  EXPECT_EQ(free.contacts, 0U);
  EXPECT_GT(free.signed_distance_m, 2e-5);
  EXPECT_EQ(free.force_error, 0.0);
  EXPECT_TRUE(free.is_accurate);
  const Answer pressed = (*method)->Query(At(1e-4, 0.0));
  EXPECT_GT(pressed.contacts, 0U);
  EXPECT_LT(pressed.signed_distance_m, -2e-5);
}

TEST(ApartBound, HasACornerOfEachPart) {
  vps::TriangleMesh two = vps::MakeBox({0.03, 0.02, 0.04});
  const vps::TriangleMesh small = vps::MakeBox({1e-3, 1e-3, 1e-3});
  const auto num_before = static_cast<std::uint32_t>(two.vertices.size());
  for (const glm::dvec3& v : small.vertices) two.vertices.push_back(v + glm::dvec3(0.1, 0.0, 0.0));
  for (const auto& t : small.triangles)
    two.triangles.push_back({t[0] + num_before, t[1] + num_before, t[2] + num_before});
  const ApartBound bound(small, two);
  ASSERT_EQ(bound.corners_of_S_m().size(), 2U);
  EXPECT_LT(bound.corners_of_S_m()[0].x, 0.05);
  EXPECT_GT(bound.corners_of_S_m()[1].x, 0.05);
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
