#include "vps/query/tree_query.hpp"

#include <gtest/gtest.h>

#include "vps/testing/brute_force.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace vps {
namespace {

struct TestPair {
  Voxmap field;
  PointTree points;
};

void ExpectSameAsBruteForce(const TestPair& s, const core::Pose& X_GS, double margin_m, QueryScratch* scratch) {
  const auto expected = QueryBruteForce(s.points, s.field, X_GS, margin_m);
  const QueryResult found = QueryTree(s.points, s.field, X_GS, margin_m, scratch);
  ASSERT_EQ(found.num_hits, expected.size());
  std::uint32_t num_colliding = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(scratch->hits[i].point, expected[i].point);
    ASSERT_EQ(scratch->hits[i].penetration_m, expected[i].penetration_m);
    num_colliding += expected[i].penetration_m >= 0.0f ? 1 : 0;
  }
  EXPECT_EQ(found.num_colliding, num_colliding);
}

TEST(QueryTree, FindsTheBruteForcePointsFor1000RandomPoses) {
  const TestPair torus{*BuildVoxmap(MakeTorus(0.1, 0.04, 96, 48), 0.002),
                       BuildTree(*BuildPointshell(MakeTorus(0.05, 0.02, 96, 48), 8000))};
  QueryScratch scratch(torus.points);
  CaseRandom random(7);
  int num_touching = 0;
  for (int i = 0; i < 1000; ++i) {
    core::Pose X_GS;
    X_GS.rotation = core::QuaternionFromRotationVector(3.0 * random.InCube());
    X_GS.translation = 0.16 * random.InCube();
    ExpectSameAsBruteForce(torus, X_GS, i % 2 == 0 ? 0.0 : 0.005, &scratch);
    if (HasFatalFailure()) return;
    num_touching += QueryTree(torus.points, torus.field, X_GS, 0.0, &scratch).num_colliding > 0 ? 1 : 0;
  }
  EXPECT_GT(num_touching, 300);
  EXPECT_LT(num_touching, 990);
}

TEST(QueryTree, FindsTheBruteForcePointsInConformingContact) {
  const TestPair peg{*BuildVoxmap(MakeBlockWithHole(0.05, 0.05, 0.01025, 64), 0.0005),
                     BuildTree(*BuildPointshell(MakeCylinder(0.01, 0.06, 64), 8000))};
  QueryScratch scratch(peg.points);
  CaseRandom random(11);
  for (int i = 0; i < 300; ++i) {
    core::Pose X_GS;
    X_GS.rotation = core::QuaternionFromRotationVector(0.02 * random.InCube());
    X_GS.translation = glm::dvec3(5e-4, 5e-4, 0.03) * random.InCube();
    ExpectSameAsBruteForce(peg, X_GS, 1e-3 * (i % 3), &scratch);
    if (HasFatalFailure()) return;
  }
}

TEST(QueryTree, TestsNoMoreThanRootSphereWhenFarApart) {
  const TestPair s{*BuildVoxmap(MakeBox({0.1, 0.1, 0.1}), 0.002),
                   BuildTree(*BuildPointshell(MakeBox({0.1, 0.1, 0.1}), 4000))};
  QueryScratch scratch(s.points);
  core::Pose X_GS;
  X_GS.translation = {1.0, 0.0, 0.0};
  const QueryResult result = QueryTree(s.points, s.field, X_GS, 0.002, &scratch);
  EXPECT_EQ(result.spheres_tested, 1U);
  EXPECT_EQ(result.points_tested, 0U);
  // True gap of the faces: 0.9 m. The root sphere sticks out of the box by (sqrt(3) - 1) 0.05 m.
  EXPECT_LT(result.free_distance_m, 0.9);
  EXPECT_GT(result.free_distance_m, 0.9 - 0.04 - 0.02);
}

TEST(QueryTree, FreeDistanceIsNeverTooLong) {
  // Move S by nearly the free distance in random directions: no hit may appear.
  const TestPair s{*BuildVoxmap(MakeTorus(0.1, 0.04, 96, 48), 0.002),
                   BuildTree(*BuildPointshell(MakeBox({0.05, 0.03, 0.02}), 3000))};
  QueryScratch scratch(s.points);
  CaseRandom random(3);
  int num_checked = 0;
  for (int i = 0; i < 2000; ++i) {
    core::Pose X_GS;
    X_GS.rotation = core::QuaternionFromRotationVector(3.0 * random.InCube());
    X_GS.translation = 0.2 * random.InCube();
    const QueryResult r = QueryTree(s.points, s.field, X_GS, 0.001, &scratch);
    if (r.free_distance_m <= 0.0) continue;
    ++num_checked;
    for (int k = 0; k < 10; ++k) {
      core::Pose moved = X_GS;
      moved.translation += 0.999 * r.free_distance_m * glm::normalize(random.InCube());
      ASSERT_EQ(QueryTree(s.points, s.field, moved, 0.001, &scratch).num_hits, 0U);
    }
  }
  EXPECT_GT(num_checked, 300);
}

}  // namespace
}  // namespace vps
