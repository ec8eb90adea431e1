#include "vps/multibody/gap_query.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vps/asset/cooked_object.hpp"
#include "vps/oracle/first_touch.hpp"
#include "vps/testing/contact_cases.hpp"

namespace vps {
namespace {

constexpr double kMicro = 1e-6;

struct GapEngine {
  GapEngine(const TriangleMesh& A, const TriangleMesh& B, double voxel_size_m, std::uint32_t num_points)
      : G(*Cook(A, {voxel_size_m, 0, Method::kFast})),
        S(*Cook(B, {0.0, num_points, Method::kFast})),
        field(*G.field),
        touch(FindTouchPoints(*S.samples, *S.surface)),
        scratch(touch.tree) {
    scratch.gaps = std::make_unique<GapScratch>();
  }
  const GapPlanes& Query(const core::Pose& X_AB) {
    scratch.found = WalkField(touch.tree, field, X_AB, WalkMargin_m(touch.tree, pair.look_ahead_m), &scratch.walk);
    FinishGapPair({touch.tree, *S.surface, *G.field, *G.bends}, touch, X_AB, X_AB, pair, 0.01, &scratch, &gaps,
                  &result);
    X_AB_now = X_AB;
    return gaps;
  }
  [[nodiscard]] double Gap_m(const core::ContactPlane& plane) const {
    return glm::dot(glm::dvec3(plane.n_G), X_AB_now * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
  }
  [[nodiscard]] core::ContactPlane Least() const {
    return *std::min_element(gaps.planes.begin(), gaps.planes.end(),
                             [&](const auto& a, const auto& b) { return Gap_m(a) < Gap_m(b); });
  }
  CookedObject G, S;
  const DistanceField& field;
  TouchPoints touch;
  FastPairScratch scratch;
  PairDescription pair;
  GapPlanes gaps;
  PairResult result;
  core::Pose X_AB_now;
};

core::Pose TurnedBy(const glm::dvec3& turn) {
  return {core::QuaternionFromRotationVector(turn), glm::dvec3(0.0)};
}

// A ball of facets over a tilted plate: the corner of the ball that is lowest has the plate's normal, and its exact
// gap, before, at and after touching, under one id.
TEST(GapQuery, ACornerOverAFaceHasTheFacesNormal) {
  GapEngine engine(MakeBox({0.1, 0.1, 0.02}), MakeSphere(0.02, 64), 1e-3, 4096);
  const core::Pose tilt = TurnedBy({0.2, 0.1, 0.0});
  const TriangleMesh ball = MakeSphere(0.02, 64);
  double lowest_m = 0.0;
  for (const glm::dvec3& v : ball.vertices) lowest_m = std::min(lowest_m, tilt.rotate(v).z);
  std::uint32_t id = 0;
  for (int i = -20; i <= 20; ++i) {
    const double gap_m = -5.0 * kMicro * i;
    core::Pose X_AB = tilt;
    X_AB.translation.z = 0.01 - lowest_m + gap_m;
    engine.Query(X_AB);
    const core::ContactPlane plane = engine.Least();
    EXPECT_NEAR(engine.Gap_m(plane), gap_m, 2.0 * kMicro);
    EXPECT_LT(glm::length(glm::dvec3(plane.n_G) - glm::dvec3(0, 0, 1)), 1e-4);
    if (i > -20) {
      EXPECT_EQ(plane.id, id);
    }
    id = plane.id;
  }
}

// Memory is not made anew for a query: what earlier ones elsewhere have left in it changes no bit.
TEST(GapQuery, WhatEarlierQueriesHaveLeftChangesNothing) {
  const TriangleMesh block = MakeBox({0.06, 0.08, 0.05});
  GapEngine used(block, MakeSphere(0.02, 64), 1e-3, 4096);
  GapEngine fresh(block, MakeSphere(0.02, 64), 1e-3, 4096);
  const double above_m = 0.025 + 0.02 - 2e-4;
  for (const glm::dvec3& p :
       {glm::dvec3(0.03, 0.04, above_m), glm::dvec3(0.03 + 0.0199, 0, 0), glm::dvec3(0, 0, -above_m)}) {
    used.Query({TurnedBy({0.3, 0.1, 0.2}).rotation, p});
    EXPECT_FALSE(used.gaps.planes.empty());
  }
  used.gaps.Clear();
  const core::Pose X_AB{TurnedBy({0.2, 0.1, 0.0}).rotation, {-0.01, 0.02, above_m}};
  used.Query(X_AB);
  fresh.Query(X_AB);
  ASSERT_FALSE(fresh.gaps.planes.empty());
  ASSERT_EQ(used.gaps.planes.size(), fresh.gaps.planes.size());
  for (std::size_t i = 0; i < fresh.gaps.planes.size(); ++i) {
    const core::ContactPlane& plane = fresh.gaps.planes[i];
    EXPECT_EQ(used.gaps.planes[i].id, plane.id);
    EXPECT_EQ(used.gaps.planes[i].p_S, plane.p_S);
    EXPECT_EQ(used.gaps.planes[i].n_G, plane.n_G);
    EXPECT_EQ(used.gaps.planes[i].q_G, plane.q_G);
  }
}

// The plate is sampled, and comes down on a corner of the other body.
TEST(GapQuery, AFaceOverACornerHasTheFacesNormal) {
  const glm::dquat up = core::QuaternionFromRotationVector(
      std::acos(1.0 / std::sqrt(3.0)) * glm::normalize(glm::cross(glm::dvec3(1.0), glm::dvec3(0, 0, 1))));
  TriangleMesh corner = MakeBox(glm::dvec3(0.03));
  for (glm::dvec3& v : corner.vertices) v = up * v;
  const double top_m = 0.03 * std::sqrt(3.0) / 2.0;
  GapEngine engine(corner, MakeBox({0.06, 0.06, 0.01}), 5e-4, 2048);
  for (int i = -10; i <= 10; ++i) {
    const double gap_m = 5.0 * kMicro * i;
    engine.Query({{1, 0, 0, 0}, {0.0041, 0.0033, top_m + 0.005 + gap_m}});
    const core::ContactPlane plane = engine.Least();
    EXPECT_NEAR(engine.Gap_m(plane), gap_m, 2.0 * kMicro);
    EXPECT_LT(glm::length(glm::dvec3(plane.n_G) - glm::dvec3(0, 0, 1)), 5e-3) << gap_m;
  }
}

// A block's corner under a ball of facets, under their faces, edges and corners: everywhere its gap is exact, and the
// ball is pushed away from it.
TEST(GapQuery, ACornerUnderARoundBodyIsFeltBetweenItsFacesToo) {
  const TriangleMesh ball = MakeSphere(0.02, 64);
  GapEngine engine(MakeBox({0.06, 0.08, 0.05}), ball, 1e-3, 4096);
  const glm::dvec3 corner_A(-0.03, -0.04, 0.025);
  CaseRandom random(7);
  for (std::size_t i = 0; i < ball.triangles.size(); i += 37) {
    const auto& t = ball.triangles[i];
    const glm::dvec3 a = ball.vertices[t[0]];
    const glm::dvec3 b = ball.vertices[t[1]];
    const glm::dvec3 c = ball.vertices[t[2]];
    for (const glm::dvec3& p_B : {a, 0.5 * (a + b), 0.9 * a + 0.1 * b, 0.99 * a + 0.01 * b, (a + b + c) / 3.0}) {
      // The block is all on one side of the plane through its corner across u, however the facets are turned.
      const glm::dvec3 u = glm::normalize(glm::dvec3(-1, -1, 1) + 0.4 * random.Direction());
      const glm::dvec3 from = -glm::normalize(p_B);
      const glm::dquat R_AB =
          core::QuaternionFromRotationVector(std::acos(glm::dot(from, u)) * glm::normalize(glm::cross(from, u)));
      for (const double gap_m : {-10.0 * kMicro, 0.0, 10.0 * kMicro}) {
        engine.gaps.Clear();
        engine.Query({R_AB, corner_A - R_AB * p_B + gap_m * u});
        ASSERT_FALSE(engine.gaps.planes.empty()) << i;
        const core::ContactPlane plane = engine.Least();
        EXPECT_NEAR(engine.Gap_m(plane), gap_m, 2.0 * kMicro) << i;
        EXPECT_GT(glm::dot(glm::dvec3(plane.n_G), u), std::cos(0.1)) << i;
      }
    }
  }
}

// A peg stands on the rim of a hole. The rim's corners are under its bottom, and far inside the planes of its side.
TEST(GapQuery, ACornerUnderABottomIsNotBehindTheSide) {
  GapEngine engine(MakeBlockWithHole(0.08, 0.04, 0.0105, 64), MakeCylinder(0.01, 0.06, 64), 5e-4, 4096);
  CaseRandom random(7);
  for (int i = 0; i < 60; ++i) {
    const double turn = random.Uniform(-3.0, 3.0);
    const double angle = random.Uniform(-3.0, 3.0);
    const double aside_m = random.Uniform(0.002, 0.012);
    for (const double gap_m : {-5.0 * kMicro, 5.0 * kMicro, 15.0 * kMicro}) {
      core::Pose X_AB = TurnedBy({0.0, 0.0, turn});
      X_AB.translation = {aside_m * std::cos(angle), aside_m * std::sin(angle), 0.02 + 0.03 + gap_m};
      engine.gaps.Clear();
      engine.Query(X_AB);
      ASSERT_FALSE(engine.gaps.planes.empty());
      EXPECT_NEAR(engine.Gap_m(engine.Least()), gap_m, 2.0 * kMicro) << i;
    }
  }
}

// An edge of a peg of sixteen faces in the groove between two faces of a hole like it has the planes of both.
TEST(GapQuery, APlaceInAGrooveHasAPlaneForEitherFace) {
  const double play_m = 5e-4;
  const double half = std::acos(-1.0) / 16.0;  // of the angle from face to face
  GapEngine engine(MakeBlockWithHole(0.06, 0.04, 0.01 + play_m, 16), MakeCylinder(0.01, 0.03, 16), 1e-3, 4096);
  engine.Query({{1, 0, 0, 0}, {play_m - 10.0 * kMicro, 0.0, 0.0}});
  int num_pairs = 0;
  for (const core::ContactPlane& a : engine.gaps.planes) {
    for (const core::ContactPlane& b : engine.gaps.planes) {
      if (glm::length(a.p_S - b.p_S) > 1e-6f || glm::length(a.n_G - b.n_G) < 0.1f) continue;
      ++num_pairs;
      EXPECT_NEAR(glm::dot(a.n_G, b.n_G), std::cos(2.0 * half), 2e-3);
      EXPECT_NEAR(engine.Gap_m(a), 10.0 * kMicro * std::cos(half), 2.0 * kMicro);
      EXPECT_NE(a.id, b.id);
    }
  }
  EXPECT_GT(num_pairs, 0);
}

// A needle thinner than a voxel, far thinner than the sampled plate's spacing, stands straight in its face; also where
// no place of the plate comes within the look-ahead of it.
TEST(GapQuery, ANeedleBetweenThePlatesPlacesIsFeltAsDeepAsItIs) {
  for (const std::uint32_t num_points : {4096U, 512U}) {
    GapEngine engine(MakeCylinder(1e-4, 0.02, 16), MakeBox({0.1, 0.1, 0.02}), 1e-3, num_points);
    for (const glm::dvec2& at : {glm::dvec2(3.7e-4, 2.3e-4), glm::dvec2(0.011, -0.017), glm::dvec2(-0.023, 0.006)}) {
      for (int i = 1; i <= 6; ++i) {
        const double depth_m = 5e-5 * i;
        engine.Query({{1, 0, 0, 0}, {at.x, at.y, -0.01 - 0.01 + depth_m}});
        ASSERT_FALSE(engine.gaps.planes.empty()) << num_points;
        const core::ContactPlane plane = engine.Least();
        EXPECT_NEAR(engine.Gap_m(plane), -depth_m, 2.0 * kMicro) << num_points;
        EXPECT_LT(glm::length(glm::dvec3(plane.n_G) - glm::dvec3(0, 0, -1)), 1e-4);
      }
    }
  }
}

// A box stands in a shaft as wide as itself along one side, a little below the rim: its bottom is over no rim.
TEST(GapQuery, AWallAlongWhichAFaceEndsIsNotUnderIt) {
  const double half_m = 0.01;
  GapEngine engine(MakeBox({0.06, 0.06, 0.04}), MakeBox(glm::dvec3(2.0 * half_m)), 5e-4, 4096);
  for (int i = -3; i <= 3; ++i) {
    const double gap_m = kMicro * i;
    engine.Query({{1, 0, 0, 0}, {0.03 + half_m + gap_m, 0.0013, 0.02 + half_m - 3e-4}});
    ASSERT_FALSE(engine.gaps.planes.empty());
    EXPECT_NEAR(engine.Gap_m(engine.Least()), gap_m, 2.0 * kMicro);
  }
}

// Two roofs across each other: the normal is across both edges.
TEST(GapQuery, CrossingEdgesHaveTheNormalOfBoth) {
  TriangleMesh roof = MakeBox(glm::dvec3(0.04));
  for (glm::dvec3& v : roof.vertices) v = TurnedBy({std::acos(-1.0) / 4.0, 0, 0}).rotate(v);  // ridges along x
  const double top_m = 0.04 * std::sqrt(0.5);
  GapEngine engine(roof, roof, 5e-4, 2048);
  const glm::dquat across = core::QuaternionFromRotationVector({0, 0, 1.1});
  for (int i = -10; i <= 10; ++i) {
    const double gap_m = 5.0 * kMicro * i;
    engine.Query({across, {0.0021, 0.0013, 2.0 * top_m + gap_m}});
    const core::ContactPlane plane = engine.Least();
    EXPECT_NEAR(engine.Gap_m(plane), gap_m, 2.0 * kMicro);
    EXPECT_LT(glm::length(glm::dvec3(plane.n_G) - glm::dvec3(0, 0, 1)), 5e-3) << gap_m;
  }
}

// A long edge of a handle that slides down over the rim of a thin plate: wherever the rim is along the edge, and so
// also under the ends of its pieces, the gap is that across both.
TEST(GapQuery, AnEdgeOverARimHasTheNormalOfBothAllAlong) {
  GapEngine engine(MakeBox({0.06, 0.06, 5e-4}), MakeBox({0.1, 0.02, 0.015}), 5e-4, 4096);
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.31, 0.94, -0.17));
  const glm::dvec3 n = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), along)) * -1.0;
  const glm::dmat3 edge_to_W(along, n, glm::cross(along, n));
  const double half = std::sqrt(0.5);
  const glm::dmat3 edge_to_S(glm::dvec3(1, 0, 0), glm::dvec3(0, half, half), glm::dvec3(0, -half, half));
  const glm::dquat R_AB = glm::normalize(glm::quat_cast(edge_to_W * glm::transpose(edge_to_S)));
  for (int i = -300; i <= 300; ++i) {
    const glm::dvec3 p_S(2.0e-5 * i, -0.01, -0.0075);
    engine.Query({R_AB, glm::dvec3(0.03, 0.0, 2.5e-4) - R_AB * p_S + 5.0 * kMicro * n});
    ASSERT_FALSE(engine.gaps.planes.empty());
    const core::ContactPlane plane = engine.Least();
    EXPECT_NEAR(engine.Gap_m(plane), 5.0 * kMicro, 2.0 * kMicro) << i;
    EXPECT_LT(glm::length(glm::dvec3(plane.n_G) - n), 5e-3) << i;
  }
}

// Least gaps at `count` first touches at random attitudes and from random sides, where the meshes' own is 0.
std::vector<double> GapsAtFirstTouch_m(const ContactCase& c, int count) {
  GapEngine engine(c.A, c.B, c.voxel_size_m, 4096);
  const oracle::MeshDistance A(c.A);
  const oracle::MeshDistance B(c.B);
  CaseRandom random(7);
  std::vector<double> gaps_m;
  while (static_cast<int>(gaps_m.size()) < count) {
    const glm::dquat R_AB = random.Rotation();
    const auto touch = oracle::FindFirstTouch(A, BoundingBox(c.A), B, BoundingBox(c.B), R_AB, random.Direction());
    if (!touch) continue;
    engine.Query(touch->Beyond(0.0));
    gaps_m.push_back(engine.gaps.planes.empty() ? 1.0 : engine.Gap_m(engine.Least()));
  }
  return gaps_m;
}

// Both are round everywhere, and as finely cut as sampled.
TEST(GapQuery, TheLeastGapOfTwoToriIsThatOfTheMeshes) {
  const ContactCase tori = ToriCase(1);
  for (const double gap_m : GapsAtFirstTouch_m(tori, 12)) EXPECT_LT(std::abs(gap_m), 0.03 * tori.voxel_size_m);
}

// What a tool may be shown too deep, or held off too early: the bound for its depth at rest on a plane.
constexpr double kShown_m = 20.0 * kMicro;

// Edges that cross far from the middles of their pieces, and corners under faces that no sample lies on.
TEST(GapQuery, TheLeastGapOfABallAtAPlateIsThatOfTheMeshes) {
  for (const double gap_m : GapsAtFirstTouch_m(BallCase(1), 24)) EXPECT_NEAR(gap_m, 0.0, kShown_m);
}
TEST(GapQuery, TheLeastGapOfAPegAtItsBlockIsThatOfTheMeshes) {
  for (const double gap_m : GapsAtFirstTouch_m(PegCase(1), 12)) EXPECT_NEAR(gap_m, 0.0, kShown_m);
}

// A ball lies at the bottom of a hollow that fits it. Far more places are near below than there are planes, but the
// ones above are there: it is not pulled through the top.
TEST(GapQuery, WhatIsPressedOnDoesNotHideWhatIsAcross) {
  constexpr double kPlay_m = 1e-4;
  TriangleMesh block = MakeBox(glm::dvec3(0.05));
  const TriangleMesh hollow = MakeSphere(0.02 + kPlay_m, 64);
  const auto first = static_cast<std::uint32_t>(block.vertices.size());
  block.vertices.insert(block.vertices.end(), hollow.vertices.begin(), hollow.vertices.end());
  for (const auto& t : hollow.triangles) block.triangles.push_back({first + t[1], first + t[0], first + t[2]});
  GapEngine engine(block, MakeSphere(0.02, 64), 5e-4, 4096);
  core::Pose X_AB;
  X_AB.translation.z = -kPlay_m;
  engine.Query(X_AB);
  EXPECT_GE(engine.gaps.planes.size(), kMaxGapPlaces);
  double way_m = 1.0;
  for (const core::ContactPlane& plane : engine.gaps.planes) {
    if (plane.n_G.z < -0.1f) way_m = std::min(way_m, -engine.Gap_m(plane) / static_cast<double>(plane.n_G.z));
  }
  EXPECT_LT(way_m, 2.5 * kPlay_m);
}

}  // namespace
}  // namespace vps
