#include "vps/asset/choose_resolution.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

using testing::HasSubstr;

PartSize Box_m(double x, double y, double z) {
  return MeasurePart(MakeBox({x, y, z}));
}

// A plain part: nothing but its longest side counts.
const PartSize& CubeSize() {
  static const PartSize cube = Box_m(0.1, 0.1, 0.1);
  return cube;
}

TEST(ChooseVoxel, TakesAShareOfTheLongestSideOfAPlainPart) {
  const ChosenVoxel voxel = ChooseVoxel(CubeSize(), CubeSize(), {});
  EXPECT_DOUBLE_EQ(voxel.size_m, 0.1 / 256.0);
  EXPECT_THAT(voxel.reason, HasSubstr("longest side, 100 mm"));
}

TEST(ChooseVoxel, PutsTwoVoxelsIntoTheThinnestWallAndTheNarrowestGap) {
  const ChosenVoxel thin = ChooseVoxel(Box_m(0.1, 0.1, 0.0005), CubeSize(), {});
  EXPECT_NEAR(thin.size_m, 0.00025, 1e-9);
  EXPECT_THAT(thin.reason, HasSubstr("half of its thinnest wall, 0.5 mm"));
  PartSize slotted = CubeSize();
  slotted.features.gap_m = 0.0004;
  const ChosenVoxel gap = ChooseVoxel(slotted, CubeSize(), {});
  EXPECT_DOUBLE_EQ(gap.size_m, 0.0002);
  EXPECT_THAT(gap.reason, HasSubstr("narrowest gap, 0.4 mm"));
}

// What LimitsOf says that voxels of this size show is there.
TEST(ChooseVoxel, ResolvesAWallByEitherMethod) {
  const PartSize plate = Box_m(0.02, 0.02, 0.0002);
  for (const Method method : {Method::kPaper, Method::kFast}) {
    const double voxel_m = ChooseVoxel(plate, CubeSize(), {.method = method}).size_m;
    EXPECT_LE(LimitsOf(method, voxel_m).thickness_m, 0.0002 * (1.0 + 1e-9));
  }
}

class InAHole : public testing::Test {
 protected:
  // A peg of 20 mm in a hole 1 mm wider: 0.5 mm on each side.
  const PartSize hole_ = MeasurePart(MakeBlockWithHole(0.08, 0.04, 0.0105, 256));
  const PartSize peg_ = MeasurePart(MakeCylinder(0.01, 0.06, 256));
};

// 0.01 voxel of error is the share `accuracy` of a depth of c / 4 where voxel = 25 accuracy c.
TEST_F(InAHole, HoldsTheAccuracyInTheClearance) {
  const ChosenVoxel fine = ChooseVoxel(hole_, peg_, {.accuracy = 0.02});
  EXPECT_NEAR(fine.size_m, 25.0 * 0.02 * 0.0005, 0.02 * fine.size_m);
  EXPECT_THAT(fine.reason, HasSubstr("accuracy in a clearance of 0.5"));
  EXPECT_NEAR(ChooseVoxel(hole_, peg_, {.accuracy = 0.01}).size_m, 0.5 * fine.size_m, 1e-9);
  // Either part may be the field.
  EXPECT_NEAR(ChooseVoxel(peg_, hole_, {.accuracy = 0.01}).size_m, 25.0 * 0.01 * 0.0005, 0.02 * 0.000125);
}

TEST_F(InAHole, KeepsTheClearanceFree) {
  const PartSize wide = MeasurePart(MakeBlockWithHole(0.08, 0.04, 0.011, 256));  // 1 mm on each side
  const ChosenVoxel paper = ChooseVoxel(wide, peg_, {.method = Method::kPaper});
  EXPECT_NEAR(LimitsOf(Method::kPaper, paper.size_m).clearance_m, 0.5 * 0.001, 1e-5);
  EXPECT_THAT(paper.reason, HasSubstr("stays free"));
  PartSize tight = hole_;  // 0.01 mm
  tight.features.gap_m = peg_.features.thickness_m + 2e-5;
  const ChosenVoxel fast = ChooseVoxel(tight, peg_, {.accuracy = 1.0});
  EXPECT_THAT(fast.reason, HasSubstr("0.05 mm would be wanted: a clearance of 0.01 mm to the other part stays free"));
}

TEST(ChooseVoxel, SaysWhenMemoryEndsIt) {
  PartSize fine = CubeSize();
  fine.features.thickness_m = 1e-6;
  const ChosenVoxel fast = ChooseVoxel(fine, CubeSize(), {});
  EXPECT_NEAR(fine.area_m2 / (fast.size_m * fast.size_m), 2e6, 1.0);
  EXPECT_THAT(fast.reason,
              testing::AllOf(HasSubstr("most memory"), HasSubstr("0.0005 mm would be wanted: half of its")));
  const ChosenVoxel paper = ChooseVoxel(fine, CubeSize(), {.method = Method::kPaper});
  EXPECT_NEAR(std::pow(0.1 / paper.size_m, 3.0), 5e7, 1.0);
  EXPECT_THAT(paper.reason, HasSubstr("most memory"));
}

TEST(ChooseVoxel, StaysWithinWhatIsAllowed) {
  const ChosenVoxel least = ChooseVoxel(CubeSize(), CubeSize(), {.least_voxel_m = 0.01});
  EXPECT_EQ(least.size_m, 0.01);
  EXPECT_THAT(least.reason, HasSubstr("the least that is allowed; 0.391 mm would be wanted"));
  EXPECT_EQ(ChooseVoxel(CubeSize(), CubeSize(), {.largest_voxel_m = 1e-4}).size_m, 1e-4);
}

TEST(ChoosePoints, StandOneVoxelApartWithinLimits) {
  EXPECT_EQ(ChoosePoints(0.01, 0.001), 10'000U);
  EXPECT_EQ(ChoosePoints(0.01, 0.1), 1'000U);
  EXPECT_EQ(ChoosePoints(0.01, 1e-5), 100'000U);
}

TEST(IsFirstSampled, IsTheNeedleAndNotThePlateInEitherOrder) {
  const PartSize needle = Box_m(0.001, 0.001, 0.05);
  const PartSize plate = Box_m(0.1, 0.1, 0.01);
  EXPECT_TRUE(IsFirstSampled(needle, plate));
  EXPECT_FALSE(IsFirstSampled(plate, needle));
  PartSize slotted = CubeSize();
  slotted.features.gap_m = 0.0004;
  EXPECT_TRUE(IsFirstSampled(slotted, needle)) << "a gap is lost as a wall is";
}

TEST(IsFirstSampled, LeavesTheSecondSampledWhenBothAreAlike) {
  EXPECT_FALSE(IsFirstSampled(CubeSize(), CubeSize()));
  PartSize wider = CubeSize();
  wider.features.thickness_m *= 1.005;
  EXPECT_FALSE(IsFirstSampled(CubeSize(), wider));
  EXPECT_FALSE(IsFirstSampled(wider, CubeSize()));
}

}  // namespace
}  // namespace vps
