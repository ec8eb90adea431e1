#include "vps/walk/field_walk.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/oracle/exact_distance.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/flat_walk.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

SampleTree Samples(const TriangleMesh& mesh, std::uint32_t count) {
  return BuildSampleTree(*SampleSurface(mesh, count));
}

constexpr InstructionSet kSets[] = {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512};

struct WalkedPair {
  DistanceField field;
  SampleTree points;
  double spread_m, angle;
};
const WalkedPair& PegInHole() {
  static const WalkedPair pair{*BuildField(MakeBlockWithHole(0.04, 0.03, 0.0105, 64), 0.0005),
                               Samples(MakeCylinder(0.01, 0.04, 64), 5000), 0.0008, 0.02};
  return pair;
}
const WalkedPair& Tori() {
  static const WalkedPair pair{*BuildField(MakeTorus(0.05, 0.02, 48, 24), 0.001),
                               Samples(MakeTorus(0.05, 0.02, 48, 24), 5000), 0.09, 3.0};
  return pair;
}

void ForPoses(const WalkedPair& pair, int count, const std::function<void(const core::Pose&)>& visit) {
  CaseRandom random(11);
  for (int i = 0; i < count; ++i) {
    core::Pose X_GS;
    X_GS.translation = pair.spread_m * random.InCube();
    X_GS.rotation = core::QuaternionFromRotationVector(pair.angle * random.InCube());
    visit(X_GS);
  }
}

// Sums equal within 1e-5, and the same points but for those whose depth is within a rounding of the limit.
void ExpectSame(const FieldWalkResult& a, const FieldWalkResult& b, const WalkedPair& pair) {
  const double s = pair.field.voxel_size_m;
  // A point that a rounding puts into the next cell: planes of neighbours and creases differ by so much of a voxel.
  const double one_point = 0.06 * s * pair.points.area_m2 / pair.points.num_points;
  const double tolerance = 1e-5 * b.volume_m3 + one_point;
  EXPECT_LE(std::abs(static_cast<double>(a.num_near) - b.num_near), 1.0 + 1e-3 * b.num_near);
  EXPECT_LE(std::abs(static_cast<double>(a.num_colliding) - b.num_colliding), 1.0 + 1e-3 * b.num_colliding);
  EXPECT_LT(glm::length(a.force_m3 - b.force_m3), tolerance);
  EXPECT_LT(glm::length(a.moment_m4 - b.moment_m4), 0.1 * tolerance);
  EXPECT_NEAR(a.volume_m3, b.volume_m3, tolerance);
  EXPECT_NEAR(a.square_m4, b.square_m4, 1e-5 * b.square_m4 + 2.0 * one_point * std::max(b.deepest_m, 0.0));
  if (a.num_near > 0 && b.num_near > 0) {
    EXPECT_NEAR(a.deepest_m, b.deepest_m, 1e-3 * s);
  }
}

void ExpectSameBits(const FieldWalkResult& a, const FieldWalkResult& b) {
  EXPECT_EQ(a.force_m3, b.force_m3);
  EXPECT_EQ(a.moment_m4, b.moment_m4);
  EXPECT_EQ(a.volume_m3, b.volume_m3);
  EXPECT_EQ(a.square_m4, b.square_m4);
  EXPECT_EQ(a.missed_m3, b.missed_m3);
  EXPECT_EQ(a.deepest_m, b.deepest_m);
  EXPECT_EQ(a.deepest_point, b.deepest_point);
  EXPECT_EQ(a.num_near, b.num_near);
  EXPECT_EQ(a.num_colliding, b.num_colliding);
  EXPECT_EQ(a.num_near_blocks, b.num_near_blocks);
}

TEST(FieldWalk, FindsWhatTestingEveryPointFinds) {
  int num_touching = 0;
  for (const WalkedPair* pair : {&PegInHole(), &Tori()}) {
    for (const double margin_m : {0.0, 0.002}) {
      ForPoses(*pair, 150, [&](const core::Pose& X_GS) {
        const FieldWalkResult flat = WalkFieldFlat(pair->points, pair->field, X_GS, margin_m);
        num_touching += flat.num_colliding > 0 ? 1 : 0;
        for (const InstructionSet set : kSets) {
          if (!IsAvailable(set)) continue;
          FieldWalkScratch scratch(pair->points, set);
          ExpectSame(WalkField(pair->points, pair->field, X_GS, margin_m, &scratch), flat, *pair);
        }
        ASSERT_FALSE(testing::Test::HasFailure());
      });
    }
  }
  EXPECT_GT(num_touching, 200);
}

TEST(FieldWalk, EveryInstructionSetGivesTheSameBits) {
  if (!IsAvailable(InstructionSet::kAvx2)) GTEST_SKIP() << "this processor has no AVX2";
  for (const WalkedPair* pair : {&PegInHole(), &Tori()}) {
    FieldWalkScratch scratch(pair->points);
    ForPoses(*pair, 100, [&](const core::Pose& X_GS) {
      const FieldWalkResult wide = WalkField(pair->points, pair->field, X_GS, 0.001, &scratch);
      for (const InstructionSet set : kSets) {
        if (!IsAvailable(set)) continue;
        FieldWalkScratch of_set(pair->points, set);
        const FieldWalkResult other = WalkField(pair->points, pair->field, X_GS, 0.001, &of_set);
        ExpectSameBits(other, wide);
        EXPECT_EQ(other.free_distance_m, wide.free_distance_m);
        EXPECT_EQ(other.points_tested, wide.points_tested);
      }
    });
  }
}

TEST(FieldWalk, ChunksGiveTheSameBitsInAnyOrder) {
  const SampleTree dense = Samples(MakeCylinder(0.01, 0.04, 64), 40000);
  FieldWalkScratch scratch(dense);
  FieldWalkScratch parts(dense);
  std::uint32_t most_chunks = 0;
  ForPoses(PegInHole(), 50, [&](const core::Pose& X_GS) {
    const FieldWalkResult whole = WalkField(dense, PegInHole().field, X_GS, 0.0005, &scratch);
    const std::uint32_t count = parts.Prepare(dense, PegInHole().field, X_GS, 0.0005);
    most_chunks = std::max(most_chunks, count);
    for (std::uint32_t i = count; i-- > 0;) parts.Evaluate(i);
    ExpectSameBits(parts.Finish(), whole);
    for (std::uint32_t i = 0; i < whole.num_near_blocks; ++i) {
      ASSERT_EQ(parts.near_blocks[i], scratch.near_blocks[i]);
      for (std::uint32_t k = 0; k < kBlock; ++k) ASSERT_EQ(parts.depths(i)[k], scratch.depths(i)[k]);
    }
  });
  EXPECT_GT(most_chunks, 4U);
}

// The missing part of the integral of the depth falls with the budget at every pose; the deepest point stays, or one
// less deep by a tenth of a voxel at most.
TEST(FieldWalk, ErrorFallsWithTheBudgetAndTheDeepestPointStays) {
  struct Case {
    const char* name;
    const DistanceField& field;
    SampleTree points;
    double spread_m, angle, margin_m;
  };
  const DistanceField comb = *BuildField(MakeBlockWithHole(0.02, 0.02, 0.004, 8), 0.0005);
  const Case cases[] = {
      {"peg", PegInHole().field, Samples(MakeCylinder(0.01, 0.04, 64), 16000), 0.0008, 0.02, 0.0},
      {"rings, light and deep", Tori().field, Samples(MakeTorus(0.05, 0.02, 48, 24), 16000), 0.09, 3.0, 0.002},
      {"facets and creases", comb, Samples(MakeCylinder(0.0042, 0.02, 8), 16000), 0.0008, 0.05, 0.0005},
  };
  for (const Case& c : cases) {
    FieldWalkScratch scratch(c.points);
    CaseRandom random(21);
    int num_cut = 0;
    int num_others = 0;
    double shallower = 0.0;  // voxels
    double missing[7] = {};
    for (int i = 0; i < 60; ++i) {
      core::Pose X_GS;
      X_GS.translation = c.spread_m * random.InCube();
      X_GS.rotation = core::QuaternionFromRotationVector(c.angle * random.InCube());
      scratch.most_points = 0;
      const FieldWalkResult whole = WalkField(c.points, c.field, X_GS, c.margin_m, &scratch);
      ASSERT_FALSE(whole.is_cut_short);
      double before = -1.0;
      std::uint32_t tested_before = 0;
      for (int b = 0; b < 7; ++b) {
        scratch.most_points = 64U << (2 * b);
        const FieldWalkResult cut = WalkField(c.points, c.field, X_GS, c.margin_m, &scratch);
        ASSERT_LE(cut.deepest_m, whole.deepest_m) << c.name;
        num_others += cut.deepest_point != whole.deepest_point ? 1 : 0;
        shallower = std::max(shallower, (whole.deepest_m - cut.deepest_m) / c.field.voxel_size_m);
        ASSERT_GE(cut.points_tested, tested_before) << c.name;
        ASSERT_GE(cut.volume_m3, before) << c.name;
        if (!cut.is_cut_short) {
          ASSERT_EQ(cut.force_m3, whole.force_m3) << c.name;
        }
        tested_before = cut.points_tested;
        before = cut.volume_m3;
        num_cut += cut.is_cut_short ? 1 : 0;
        missing[b] += glm::length(cut.force_m3 - whole.force_m3);
      }
      ASSERT_LE(before, whole.volume_m3);
    }
    EXPECT_GT(num_cut, 30) << c.name;
    EXPECT_LE(num_others, 20) << c.name;  // of 420: others as deep
    EXPECT_LE(shallower, 0.1) << c.name;
    for (int b = 1; b < 7; ++b) EXPECT_LE(missing[b], missing[b - 1]) << c.name << ", budget " << (64 << (2 * b));
    EXPECT_EQ(missing[6], 0.0) << c.name;
  }
}

// S may move by the free distance in any direction without a point coming within the margin.
TEST(FieldWalk, FreeDistanceIsFree) {
  const WalkedPair& pair = Tori();
  FieldWalkScratch scratch(pair.points);
  CaseRandom random(4);
  int num_apart = 0;
  ForPoses(pair, 300, [&](const core::Pose& X) {
    core::Pose X_GS = X;
    X_GS.translation *= 2.0;
    const FieldWalkResult result = WalkField(pair.points, pair.field, X_GS, 0.002, &scratch);
    if (result.num_near > 0) return;
    ++num_apart;
    for (int i = 0; i < 5; ++i) {
      core::Pose moved = X_GS;
      moved.translation += 0.9999 * result.free_distance_m * glm::normalize(random.InCube());
      ASSERT_EQ(WalkFieldFlat(pair.points, pair.field, moved, 0.002).num_near, 0U);
    }
  });
  EXPECT_GT(num_apart, 50);
}

// A ball of radius r pressed by h into a plate: the integral of depth times normal over the cap is the volume of the
// cap, pi h^2 (r - h/3), whatever the number of points.
TEST(FieldWalk, ForceOfABallInAPlateIsTheVolumeOfItsCap) {
  const DistanceField plate = *BuildField(MakeBox({0.1, 0.1, 0.04}), 0.0005);
  const double r = 0.02;
  for (const std::uint32_t count : {4096U, 16384U, 65536U}) {
    const SampleTree ball = Samples(MakeSphere(r, 128), count);
    FieldWalkScratch scratch(ball);
    for (const double h : {0.001, 0.003, 0.006}) {
      core::Pose X_GS;
      X_GS.translation = {0.003, 0.002, 0.02 + r - h};
      const FieldWalkResult result = WalkField(ball, plate, X_GS, 0.0, &scratch);
      const double volume_m3 = M_PI * h * h * (r - h / 3.0);
      // The mesh is up to 12 um inside the ball.
      const double tolerance = (count == 65536U ? 0.01 : (result.num_colliding > 200 ? 0.025 : 0.06)) + 2.0 * 8e-6 / h;
      EXPECT_NEAR(result.force_m3.z / volume_m3, 1.0, tolerance) << count << " " << h;
      EXPECT_LT(std::hypot(result.force_m3.x, result.force_m3.y), 0.02 * result.force_m3.z);
    }
  }
}

// The same ball at random places and depths. What the samples miss is within four standard deviations of what they
// tell, although here, where the border is a circle in a plane, neighbours lie alike all around; and it is no empty
// bound: with four times as many it is a fifth.
TEST(FieldWalk, WhatSamplesMissIsWithinWhatTheyTell) {
  const DistanceField plate = *BuildField(MakeBox({0.1, 0.1, 0.04}), 0.0005);
  constexpr double kRadius = 0.02;
  constexpr int kNumPoses = 200;
  double told[2] = {};
  for (const int i : {0, 1}) {
    const SampleTree ball = Samples(MakeSphere(kRadius, 256), i == 0 ? 4096 : 16384);
    FieldWalkScratch scratch(ball);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    int num_beyond = 0;
    for (int k = 0; k < kNumPoses; ++k) {
      const double h = 0.001 + 0.003 * share(random);
      core::Pose X_GS;
      X_GS.translation = {0.02 * share(random), 0.02 * share(random), 0.02 + kRadius - h};
      X_GS.rotation =
          glm::angleAxis(6.0 * share(random), glm::normalize(glm::dvec3(share(random), 0.3, share(random))));
      const FieldWalkResult result = WalkField(ball, plate, X_GS, ball.usual_m, &scratch);
      const double exact_m3 = M_PI * h * h * (kRadius - h / 3.0);
      const double of_mesh = 2.0 * 3e-6 / h * exact_m3;  // it is up to 3 um inside the ball
      num_beyond += std::abs(glm::length(result.force_m3) - exact_m3) > 4.0 * result.missed_m3 + of_mesh ? 1 : 0;
      told[i] += result.missed_m3 / exact_m3 / kNumPoses;
    }
    EXPECT_EQ(num_beyond, 0);
  }
  EXPECT_LT(told[0], 0.1);
  EXPECT_NEAR(told[0] / told[1], 5.0, 1.0);
}

// A step of 1 um changes the force by no more than twice the smooth change, also when points come in.
TEST(FieldWalk, ForceDoesNotJumpWhenPointsTouch) {
  const DistanceField plate = *BuildField(MakeBox({0.1, 0.1, 0.04}), 0.0005);
  const double r = 0.02;
  const SampleTree ball = Samples(MakeSphere(r, 96), 4096);
  FieldWalkScratch scratch(ball);
  double before = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double h = 1e-4 + 1e-6 * i;
    core::Pose X_GS;
    X_GS.translation = {0.0, 0.0, 0.02 + r - h};
    const double force = WalkField(ball, plate, X_GS, 0.0, &scratch).force_m3.z;
    // dF/dh = pi h (2 r - h), the area of the cut, which is sampled by few points: half a point's area is allowed
    // besides.
    const double smooth = M_PI * h * (2.0 * r - h) * 1e-6;
    if (i > 0) {
      ASSERT_LE(std::abs(force - before), 2.0 * smooth + 1e-6 * ball.area_m2 / 4096.0) << h;
    }
    before = force;
  }
}

TEST(FieldWalk, DeepContactPushesTheRightWay) {
  const DistanceField ball = *BuildField(MakeSphere(0.05, 96), 0.0005);
  const SampleTree small = Samples(MakeSphere(0.01, 48), 2000);
  FieldWalkScratch scratch(small);
  core::Pose X_GS;
  X_GS.translation = {0.02, 0.0, 0.0};  // whole, 20 mm deep
  const FieldWalkResult result = WalkField(small, ball, X_GS, 0.0, &scratch);
  EXPECT_EQ(result.num_colliding, 2000U);
  // The integral of depth n dA over a closed surface is minus the volume integral of the depth's gradient: the volume
  // times the mean direction, here close to +x.
  const double volume = 4.0 / 3.0 * M_PI * 1e-6;
  EXPECT_NEAR(result.force_m3.x / volume, 1.0, 0.06);
  EXPECT_NEAR(result.deepest_m, 0.04, 1e-3);
}

// The peg's axis is shifted by e in a hole wider by the clearance c: at the angle phi from the shift it is e cos(phi) -
// c deep. Of the depth times cos(phi), over the length L of the hole and the angles where it is positive, |phi| <
// phi_0:
//   F = R L (e (phi_0 + sin(phi_0) cos(phi_0)) - 2 c sin(phi_0)),  cos(phi_0) = c / e.
// Points lie inside their patch of the peg, by its area / 24 R, a tenth of the depth and more with so few.
TEST(FieldWalk, AFewPointsIntegrateThePressureOnACurvedWall) {
  const double R = 0.01;
  const double c = 5e-5;
  const double L = 0.03;
  const DistanceField hole = *BuildField(MakeBlockWithHole(0.04, L, R + c, 256), 0.00025);
  const SampleTree peg = Samples(MakeCylinder(R, 0.04, 256), 6000);
  FieldWalkScratch scratch(peg);
  for (const double e : {9e-5, 1.2e-4, 2e-4}) {
    core::Pose X_GS;
    X_GS.translation = {e * std::cos(0.3), e * std::sin(0.3), 0.0};
    const double phi = std::acos(c / e);
    const double force = R * L * (e * (phi + std::sin(phi) * std::cos(phi)) - 2.0 * c * std::sin(phi));
    EXPECT_NEAR(glm::length(WalkField(peg, hole, X_GS, 0.0, &scratch).force_m3) / force, 1.0, 0.02) << e;
  }
}

TEST(FieldWalk, AFreePegInATightHoleTouchesNothing) {
  // 20 mm peg, 0.1 mm clearance on the diameter; facets of both turned alike.
  const DistanceField hole = *BuildField(MakeBlockWithHole(0.04, 0.03, 0.01005, 256), 0.00025);
  const SampleTree peg = Samples(MakeCylinder(0.01, 0.02, 256), 20000);
  FieldWalkScratch scratch(peg);
  EXPECT_EQ(WalkField(peg, hole, {}, 0.0, &scratch).num_colliding, 0U);
}

}  // namespace
}  // namespace vps
