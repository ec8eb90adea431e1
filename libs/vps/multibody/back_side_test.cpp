#include "vps/multibody/back_side.hpp"

#include <gtest/gtest.h>

#include "vps/field/build_field.hpp"
#include "vps/mesh/shapes.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/oracle/contact_wrench.hpp"

namespace vps {
namespace {

core::Pose At(double x, double y, double z, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(turn), {x, y, z}};
}

// A thin rib (A, the field) against the broad face of a plate (B) whose points are farther apart than the rib is thick.
struct RibAndPlate {
  TriangleMesh rib = MakeBox({0.0015, 0.02, 0.03});
  TriangleMesh plate = MakeBox({0.1, 0.1, 0.01});
  DistanceField rib_field = *BuildField(rib, 5e-4);
  DistanceField plate_field = *BuildField(plate, 5e-4);
  SampleTree rib_points = BuildSampleTree(*SampleSurface(rib, 4096));
  SampleTree plate_points = BuildSampleTree(*SampleSurface(plate, 2048));
  FastPairScratch scratch{plate_points, rib_points};
  PairDescription pair{.look_ahead_m = 0.0};
  PairResult result;

  // X_GS: the plate lies on top of the rib, pressed down by `depth_m`.
  core::Pose Pressed(double depth_m, double x = 0.0) const {
    return At(x, 0.001, 0.015 + 0.005 - depth_m, {0.0, 0.02, 0.3});
  }
  void Query(const core::Pose& X_GS, bool has_back) {
    const BackSide back{&rib_points, &plate_field};
    QueryFastPair(plate_points, rib_field, X_GS, X_GS, pair, 0.01, &scratch, &result, has_back ? back : BackSide{});
  }
};

TEST(BackSide, SeesWhatSlipsBetweenThePoints) {
  RibAndPlate pair;
  EXPECT_TRUE(NeedsBackSide(pair.plate_points, pair.rib_points));
  EXPECT_FALSE(NeedsBackSide(pair.rib_points, BuildSampleTree(*SampleSurface(MakeTorus(0.05, 0.02, 64, 32), 4096))));
  const oracle::MeshDistance A(pair.rib);
  const oracle::MeshDistance B(pair.plate);
  double worst = 0.0;
  double worst_without = 0.0;
  for (int i = 0; i < 20; ++i) {
    const core::Pose X = pair.Pressed(3e-4 + 1e-5 * i, 4e-4 * i);
    const oracle::ContactWrench truth = oracle::IntegrateContactWrench(A, B, X);
    const auto error = [&] {
      return glm::length(X.rotate(pair.scratch.force_m3) - truth.force_A_m3) / glm::length(truth.force_A_m3);
    };
    pair.Query(X, false);
    worst_without = std::max(worst_without, error());
    pair.Query(X, true);
    EXPECT_TRUE(pair.result.is_in_contact);
    worst = std::max(worst, error());
    EXPECT_NEAR(-pair.result.signed_distance_m, oracle::FindDeepest(B, A, X.inverse()).depth_m, 3e-5);
  }
  EXPECT_GT(worst_without, 0.2);
  EXPECT_LT(worst, 0.1);
}

TEST(BackSide, BothEstimatesAgreeOnAFlatFace) {
  const TriangleMesh box = MakeBox({0.02, 0.02, 0.02});
  const TriangleMesh plate = MakeBox({0.1, 0.1, 0.02});
  const DistanceField box_field = *BuildField(box, 5e-4);
  const DistanceField plate_field = *BuildField(plate, 5e-4);
  const SampleTree box_points = BuildSampleTree(*SampleSurface(box, 4096));
  const SampleTree plate_points = BuildSampleTree(*SampleSurface(plate, 32768));
  const core::Pose X_GS = At(0.003, 0.002, 0.02 - 3e-4, {0.004, 0.01, 0.4});
  FieldWalkScratch front(box_points);
  FieldWalkScratch back(plate_points);
  const FieldWalkResult walk = WalkField(box_points, plate_field, X_GS, 0.0, &front);
  const FieldWalkResult behind = WalkField(plate_points, box_field, X_GS.inverse(), 0.0, &back);
  std::uint32_t unused = 0;
  const BackSum sum = SumBackSide({&plate_points, &box_field}, plate_field, X_GS, behind, back, 0.0, {}, &unused);
  EXPECT_LT(glm::length(sum.force_m3 - walk.force_m3), 0.02 * glm::length(walk.force_m3));
  EXPECT_LT(glm::length(sum.moment_m4 - walk.moment_m4), 0.02 * 0.01 * glm::length(walk.force_m3));
}

// The share of either side changes with the pose, and nothing jumps.
TEST(BackSide, ForceHasNoSteps) {
  RibAndPlate pair;
  double before = 0.0;
  double largest = 0.0;
  for (int i = 0; i <= 400; ++i) {
    pair.Query(pair.Pressed(-1e-5 + 1e-6 * i, 1e-6 * i), true);
    const double force = glm::length(pair.scratch.force_m3);
    if (i > 0) largest = std::max(largest, std::abs(force - before));
    before = force;
  }
  EXPECT_LT(largest, 2.0 * 1e-6 * 0.0015 * 0.02);  // area of the rib's end times the step
  EXPECT_GT(before, 0.5 * 3e-4 * 0.0015 * 0.02);
}

}  // namespace
}  // namespace vps
