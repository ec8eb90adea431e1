#include "vps/walk/field_walk.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/mesh/shapes.hpp"
#include "vps/oracle/exact_distance.hpp"

namespace vps {
namespace {

double Signed(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

SampleTree Samples(const TriangleMesh& mesh, std::uint32_t count) {
  return BuildSampleTree(*SampleSurface(mesh, count));
}

constexpr InstructionSet kSets[] = {InstructionSet::kPortable, InstructionSet::kAvx2, InstructionSet::kAvx512};

struct Pair {
  DistanceField field;
  SampleTree points;
  double spread_m, angle;
};
const Pair& PegInHole() {
  static const Pair pair{*BuildField(MakeBlockWithHole(0.04, 0.03, 0.0105, 64), 0.0005),
                         Samples(MakeCylinder(0.01, 0.04, 64), 5000), 0.0008, 0.02};
  return pair;
}
const Pair& Tori() {
  static const Pair pair{*BuildField(MakeTorus(0.05, 0.02, 48, 24), 0.001),
                         Samples(MakeTorus(0.05, 0.02, 48, 24), 5000), 0.09, 3.0};
  return pair;
}

void ForPoses(const Pair& pair, int count, const std::function<void(const core::Pose&)>& visit) {
  std::mt19937_64 random(11);
  for (int i = 0; i < count; ++i) {
    core::Pose X_GS;
    X_GS.translation = pair.spread_m * glm::dvec3(Signed(random), Signed(random), Signed(random));
    X_GS.rotation =
        core::QuaternionFromRotationVector(pair.angle * glm::dvec3(Signed(random), Signed(random), Signed(random)));
    visit(X_GS);
  }
}

TEST(FieldWalk, FindsWhatTestingEveryPointFinds) {
  int num_touching = 0;
  for (const Pair* pair : {&PegInHole(), &Tori()}) {
    FieldWalkScratch scratch(pair->points);
    for (const double margin_m : {0.0, 0.002}) {
      ForPoses(*pair, 150, [&](const core::Pose& X_GS) {
        const FieldWalkResult flat = WalkFieldFlat(pair->points, pair->field, X_GS, margin_m);
        const FieldWalkResult tree = WalkField(pair->points, pair->field, X_GS, margin_m, &scratch);
        ASSERT_EQ(tree.num_near, flat.num_near);
        ASSERT_EQ(tree.num_colliding, flat.num_colliding);
        num_touching += flat.num_colliding > 0 ? 1 : 0;
        if (flat.num_near == 0) return;
        ASSERT_EQ(tree.deepest_point, flat.deepest_point);
        ASSERT_EQ(tree.deepest_m, flat.deepest_m);
        const double scale = flat.volume_m3 + 1e-30;
        ASSERT_LT(glm::length(tree.force_m3 - flat.force_m3), 1e-5 * scale);
        ASSERT_LT(glm::length(tree.moment_m4 - flat.moment_m4), 1e-5 * 0.1 * scale);
        ASSERT_NEAR(tree.volume_m3, flat.volume_m3, 1e-5 * scale);
        ASSERT_NEAR(tree.square_m4, flat.square_m4, 1e-5 * flat.square_m4 + 1e-30);
      });
    }
  }
  EXPECT_GT(num_touching, 200);
}

TEST(FieldWalk, EveryInstructionSetGivesTheSameBits) {
  for (const Pair* pair : {&PegInHole(), &Tori()}) {
    FieldWalkScratch scratch(pair->points);
    ForPoses(*pair, 100, [&](const core::Pose& X_GS) {
      const FieldWalkResult first =
          WalkField(pair->points, pair->field, X_GS, 0.001, InstructionSet::kPortable, &scratch);
      for (const InstructionSet set : kSets) {
        if (!IsAvailable(set)) continue;
        const FieldWalkResult other = WalkField(pair->points, pair->field, X_GS, 0.001, set, &scratch);
        ASSERT_EQ(other.force_m3, first.force_m3);
        ASSERT_EQ(other.moment_m4, first.moment_m4);
        ASSERT_EQ(other.volume_m3, first.volume_m3);
        ASSERT_EQ(other.square_m4, first.square_m4);
        ASSERT_EQ(other.deepest_m, first.deepest_m);
        ASSERT_EQ(other.deepest_point, first.deepest_point);
        ASSERT_EQ(other.num_near, first.num_near);
        ASSERT_EQ(other.points_tested, first.points_tested);
        ASSERT_EQ(other.free_distance_m, first.free_distance_m);
      }
    });
  }
}

// S may move by the free distance in any direction without a point coming within the margin.
TEST(FieldWalk, FreeDistanceIsFree) {
  const Pair& pair = Tori();
  FieldWalkScratch scratch(pair.points);
  std::mt19937_64 random(4);
  int num_apart = 0;
  ForPoses(pair, 300, [&](const core::Pose& X) {
    core::Pose X_GS = X;
    X_GS.translation *= 2.0;
    const FieldWalkResult result = WalkField(pair.points, pair.field, X_GS, 0.002, &scratch);
    if (result.num_near > 0) return;
    ++num_apart;
    for (int i = 0; i < 5; ++i) {
      core::Pose moved = X_GS;
      moved.translation +=
          0.9999 * result.free_distance_m * glm::normalize(glm::dvec3(Signed(random), Signed(random), Signed(random)));
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
    // dF/dh = pi h (2 r - h): the area of the cut; a few points stand for it, so half of one more is allowed.
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

TEST(FieldWalk, AFreePegInATightHoleTouchesNothing) {
  // 20 mm peg, 0.1 mm clearance on the diameter; facets of both turned alike.
  const DistanceField hole = *BuildField(MakeBlockWithHole(0.04, 0.03, 0.01005, 256), 0.00025);
  const SampleTree peg = Samples(MakeCylinder(0.01, 0.02, 256), 20000);
  FieldWalkScratch scratch(peg);
  EXPECT_EQ(WalkField(peg, hole, {}, 0.0, &scratch).num_colliding, 0U);
}

}  // namespace
}  // namespace vps
