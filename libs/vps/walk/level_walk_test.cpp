#include "vps/walk/level_walk.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

// A peg of 20 mm in a hole 0.1 mm wider.
const DistanceField& Hole() {
  static const DistanceField field = *BuildField(MakeBlockWithHole(0.04, 0.03, 0.01005, 256), 0.00025);
  return field;
}
const SampleTree& Peg() {
  static const SampleTree tree = *BuildSampleTree(MakeCylinder(0.01, 0.04, 256), 50000);
  return tree;
}
core::Pose Pressed(double shift_m, double angle = 0.3) {
  core::Pose X_GS;
  X_GS.translation = {shift_m * std::cos(angle), shift_m * std::sin(angle), 0.0};
  return X_GS;
}

FieldWalkResult Walk(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m,
                     FieldWalkScratch* scratch, LevelWalk* levels) {
  std::uint32_t num_chunks = levels->Begin(sampled, field, X_GS, margin_m, BestInstructionSet(), scratch);
  do {
    for (std::uint32_t i = 0; i < num_chunks; ++i) EvaluateChunk(scratch, i);
    num_chunks = levels->Next();
  } while (num_chunks > 0);
  return levels->result();
}

TEST(LevelWalk, AQuarterOfThePointsIntegratesABroadContact) {
  ASSERT_EQ(Peg().coarser.size(), 1U);
  FieldWalkScratch scratch(Peg());
  LevelWalk levels;
  for (const double shift_m : {1.2e-4, 2e-4, 3e-4}) {
    const FieldWalkResult all = WalkField(Peg(), Hole(), Pressed(shift_m), 0.0, &scratch);
    const FieldWalkResult few = Walk(Peg(), Hole(), Pressed(shift_m), 0.0, &scratch, &levels);
    EXPECT_TRUE(levels.is_coarse());
    EXPECT_LT(few.points_tested, 0.35 * all.points_tested);  // a quarter, and their wider blocks
    EXPECT_LT(glm::length(few.force_m3 - all.force_m3), 0.01 * glm::length(all.force_m3)) << shift_m;
    EXPECT_NEAR(few.deepest_m, all.deepest_m, 5e-6);
  }
}

TEST(LevelWalk, ASmallContactUsesAllPoints) {
  const DistanceField box = *BuildField(MakeBox({0.05, 0.05, 0.02}), 0.0005);
  const SampleTree ball = *BuildSampleTree(MakeSphere(0.02, 96), 40000);
  FieldWalkScratch scratch(ball);
  LevelWalk levels;
  for (const double height_m : {0.0299, 0.0297}) {
    core::Pose X_GS;
    X_GS.translation.z = height_m;
    const FieldWalkResult all = WalkField(ball, box, X_GS, 0.0, &scratch);
    const FieldWalkResult result = Walk(ball, box, X_GS, 0.0, &scratch, &levels);
    ASSERT_GT(all.num_colliding, 0U);
    EXPECT_FALSE(levels.is_coarse());
    EXPECT_EQ(result.force_m3, all.force_m3);
    EXPECT_EQ(result.num_near_blocks, all.num_near_blocks);
  }
}

// While the peg is pressed in from nothing the coarser points take over. The force grows by the area that touches times
// the step; where they take over it may not change by more than twice that.
TEST(LevelWalk, TheForceIsContinuousWhereCoarserPointsTakeOver) {
  FieldWalkScratch scratch(Peg());
  LevelWalk levels;
  bool was_fine = false;
  bool was_coarse = false;
  double before = 0.0;
  double step_before = 0.0;
  for (int i = 0; i < 160; ++i) {
    const double step_m = 1e-6;
    const FieldWalkResult result = Walk(Peg(), Hole(), Pressed(5e-5 + i * step_m), 0.0, &scratch, &levels);
    const double force = glm::length(result.force_m3);
    const double area_m2 = result.square_m4 > 0.0 ? result.volume_m3 * result.volume_m3 / result.square_m4 : 0.0;
    if (i > 5) {
      EXPECT_LE(force - before, 2.0 * area_m2 * step_m) << i;
    }
    EXPECT_GE(force, before) << i;
    const double step = force - before;
    if (i > 20) {
      EXPECT_NEAR(step / step_before, 1.0, 0.08) << i;  // 0.06; without blending 0.12 where the levels change
    }
    step_before = step;
    before = force;
    was_fine |= result.num_colliding > 0 && !levels.is_coarse();
    was_coarse |= levels.is_coarse();
  }
  EXPECT_TRUE(was_fine);
  EXPECT_TRUE(was_coarse);
}

TEST(LevelWalk, DependsOnThePoseAlone) {
  FieldWalkScratch anew(Peg());
  FieldWalkScratch with(Peg());
  FieldWalkMemory memory;
  with.memory = &memory;
  LevelWalk levels;
  std::mt19937_64 random(5);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  int num_coarse = 0;
  double shift_m = 5e-5;
  double angle = 0.0;
  for (int i = 0; i < 400; ++i) {
    shift_m = i % 40 == 0 ? 4e-5 + 1e-4 * uniform() : shift_m + 4e-6 * (uniform() - 0.5);
    angle += 2e-4 * (uniform() - 0.5);
    const FieldWalkResult a = Walk(Peg(), Hole(), Pressed(shift_m, angle), 0.0, &anew, &levels);
    num_coarse += levels.is_coarse() ? 1 : 0;
    const FieldWalkResult b = Walk(Peg(), Hole(), Pressed(shift_m, angle), 0.0, &with, &levels);
    ASSERT_EQ(a.force_m3, b.force_m3) << i;
    ASSERT_EQ(a.moment_m4, b.moment_m4) << i;
    ASSERT_EQ(a.num_colliding, b.num_colliding) << i;
    ASSERT_EQ(a.deepest_m, b.deepest_m) << i;
  }
  EXPECT_GT(num_coarse, 50);
  EXPECT_LT(num_coarse, 350);
}

// A tilted plate touches with one corner, a list of blocks that may touch next is made, and within the list's skin the
// plate comes to lie flat.
TEST(LevelWalk, TheMemoryOfASmallContactIsNotUsedForABroadOne) {
  const double s = 5e-4;
  const DistanceField box = *BuildField(MakeBox({0.06, 0.06, 0.02}), s);
  const SampleTree plate = *BuildSampleTree(MakeBox({0.04, 0.04, 0.01}), 60000);
  const auto lifted = [&](double voxels) {  // at the far corner
    core::Pose X_GS;
    X_GS.translation.z = 0.015 - 1e-5 + 0.5 * voxels * s;
    X_GS.rotation = core::QuaternionFromRotationVector(voxels * s / 0.08 * glm::dvec3(1.0, -1.0, 0.0));
    return X_GS;
  };
  FieldWalkScratch scratch(plate);
  FieldWalkMemory memory;
  scratch.memory = &memory;
  for (const double voxels : {0.48, 0.38, 0.37}) WalkField(plate, box, lifted(voxels), 0.0, &scratch);
  LevelWalk levels;
  const FieldWalkResult with = Walk(plate, box, lifted(0.0), 0.0, &scratch, &levels);
  EXPECT_TRUE(levels.is_coarse());
  FieldWalkScratch anew(plate);
  const FieldWalkResult without = Walk(plate, box, lifted(0.0), 0.0, &anew, &levels);
  EXPECT_EQ(with.force_m3, without.force_m3);
  EXPECT_EQ(with.num_colliding, without.num_colliding);
}

TEST(LevelWalk, ABudgetUsesTheFinestPoints) {
  FieldWalkScratch scratch(Peg());
  scratch.most_points = 2048;
  LevelWalk levels;
  const FieldWalkResult cut = Walk(Peg(), Hole(), Pressed(2e-4), 0.0, &scratch, &levels);
  EXPECT_TRUE(cut.is_cut_short);
  EXPECT_FALSE(levels.is_coarse());
  EXPECT_LE(cut.points_tested, 2048U);
}

}  // namespace
}  // namespace vps
