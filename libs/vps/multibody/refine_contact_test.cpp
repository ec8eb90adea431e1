#include "vps/multibody/refine_contact.hpp"

#include <gtest/gtest.h>

#include "vps/field/build_field.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/contact_wrench.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

core::Pose At(double x, double y, double z, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(turn), {x, y, z}};
}

TEST(FineBlock, CoversItsSamplesPatch) {
  const SurfaceSamples samples = *SampleSurface(MakeTorus(0.03, 0.012, 64, 32), 2048);
  const SampleTree tree = BuildSampleTree(samples);
  ASSERT_EQ(tree.fine.size(), tree.num_points);
  for (std::uint32_t i = 0; i < tree.num_points; ++i) {
    const PointBlock& block = tree.points[i / kBlock];
    const std::uint32_t lane = i % kBlock;
    PointBlock points;
    Unpack(tree.fine[i], block, lane, 1.0f, &points);
    float area_m2 = 0.0f;
    glm::vec3 middle(0.0f);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const glm::vec3 p(points.x[k], points.y[k], points.z[k]);
      area_m2 += points.area_m2[k];
      middle += points.area_m2[k] * p;
      EXPECT_LE(glm::length(p - glm::vec3(block.x[lane], block.y[lane], block.z[lane])), tree.fine[i].reach_m);
      EXPECT_NEAR(glm::length(glm::vec3(points.nx[k], points.ny[k], points.nz[k])), 1.0f, 0.02f);
    }
    EXPECT_NEAR(area_m2, block.area_m2[lane], 1e-5f * block.area_m2[lane]);
    EXPECT_LT(glm::length(middle / area_m2 - glm::vec3(block.x[lane], block.y[lane], block.z[lane])),
              0.01f * std::sqrt(area_m2));
  }
}

// A thin rib (the field) on the broad face of a plate whose samples are farther apart than the rib is thick.
struct RibAndPlate {
  TriangleMesh rib = MakeBox({0.0015, 0.02, 0.03});
  TriangleMesh plate = MakeBox({0.1, 0.1, 0.01});
  DistanceField field = *BuildField(rib, 5e-4);
  SampleTree samples = BuildSampleTree(*SampleSurface(plate, 2048));
  FastPairScratch scratch{samples};
  PairDescription pair{.look_ahead_m = 0.0};
  PairResult result;

  // X_GS: the plate lies on top of the rib, pressed down by `depth_m`.
  static core::Pose Pressed(double depth_m, double x = 0.0) {
    return At(x, 0.001, 0.015 + 0.005 - depth_m, {0.0, 0.02, 0.3});
  }
  void Query(const core::Pose& X_GS) { QueryFastPair(samples, field, X_GS, X_GS, pair, 0.01, &scratch, &result); }
};

TEST(RefineContact, ResolvesARibBetweenTheSamples) {
  RibAndPlate pair;
  const oracle::MeshDistance A(pair.rib);
  const oracle::MeshDistance B(pair.plate);
  FieldWalkScratch walk(pair.samples);
  double worst = 0.0;
  double worst_without = 0.0;
  for (int i = 0; i < 8; ++i) {
    const core::Pose X = RibAndPlate::Pressed(3e-4 + 2e-5 * i, 1e-3 * i);
    const glm::dvec3 truth = oracle::IntegrateContactWrench(A, B, X).force_A_m3;
    const auto error = [&](const glm::dvec3& force_S) {
      return glm::length(X.rotate(force_S) - truth) / glm::length(truth);
    };
    pair.Query(X);
    EXPECT_TRUE(pair.result.is_in_contact);
    worst = std::max(worst, error(pair.scratch.force_m3));
    worst_without = std::max(worst_without, error(WalkField(pair.samples, pair.field, X, 0.0, &walk).force_m3));
  }
  EXPECT_GT(worst_without, 2.0 * worst);
  EXPECT_LT(worst, 0.2);
}

// A ball (the field) presses h below the middle of its bottom into a plate of few samples. At a distance r from the
// axis the depth is R - sqrt(r^2 + (R - h)^2); over the disc of radius sqrt(R^2 - (R - h)^2) that is, with c = R - h,
// pi (R (R^2 - c^2) - 2/3 (R^3 - c^3)).
TEST(RefineContact, IsUnbiasedInsideARoundPart) {
  constexpr double R = 0.01;
  constexpr double h = 0.003;
  constexpr double c = R - h;
  const double exact = M_PI * (R * (R * R - c * c) - 2.0 / 3.0 * (R * R * R - c * c * c));
  const DistanceField field = *BuildField(MakeSphere(R, 192), 2.5e-4);
  const SampleTree samples = BuildSampleTree(*SampleSurface(MakeBox({0.1, 0.1, 0.01}), 8192));
  FastPairScratch scratch(samples);
  PairResult result;
  double mean = 0.0;
  constexpr int kPlaces = 64;
  for (int i = 0; i < kPlaces; ++i) {
    const int row = i / 8;
    const core::Pose X_GS = At(2.3e-4 * (i % 8), 2.9e-4 * row, R - h + 0.005);
    QueryFastPair(samples, field, X_GS, X_GS, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
    EXPECT_GT(scratch.refine.num_samples, 0U);
    mean += glm::length(scratch.force_m3) / exact / kPlaces;
  }
  EXPECT_NEAR(mean, 1.0, 0.005);
}

// The weights of samples and of the whole change with the pose, and nothing jumps.
TEST(RefineContact, ForceIsContinuous) {
  RibAndPlate pair;
  double before = 0.0;
  double largest = 0.0;
  for (int i = 0; i <= 400; ++i) {
    pair.Query(RibAndPlate::Pressed(-1e-5 + 1e-6 * i, 1e-6 * i));
    const double force = glm::length(pair.scratch.force_m3);
    if (i > 0) largest = std::max(largest, std::abs(force - before));
    before = force;
  }
  EXPECT_LT(largest, 2.0 * 1e-6 * 0.0015 * 0.02);  // area of the rib's end times the step
  EXPECT_GT(before, 0.5 * 3e-4 * 0.0015 * 0.02);
}

// From where all samples of a ball's contact are refined until none is.
TEST(RefineContact, FadesOutContinuously) {
  constexpr double R = 0.06;
  const DistanceField field = *BuildField(MakeSphere(R, 192), 1e-3);
  const SampleTree samples = BuildSampleTree(*SampleSurface(MakeBox({0.1, 0.1, 0.02}), 24576));
  FastPairScratch scratch(samples);
  PairResult result;
  double before = 0.0;
  std::uint32_t most_refined_samples = 0;
  std::uint64_t most_refined = 0;
  for (int i = 0; i <= 1600; ++i) {
    const double h = 1.5e-3 + 4e-6 * i;
    const core::Pose X_GS = At(3e-4, 7e-4, R - h + 0.01, {0.03, 0.02, 0.4});
    QueryFastPair(samples, field, X_GS, X_GS, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
    const double force = glm::length(scratch.force_m3);
    if (i > 0) {
      EXPECT_LT(std::abs(force - before), 1.5 * 4e-6 * M_PI * 2.0 * R * h) << i;
    }
    most_refined_samples = std::max(most_refined_samples, scratch.refine.num_samples);
    if (scratch.refine.num_samples > 0) most_refined = std::max(most_refined, result.counters.points_colliding);
    before = force;
  }
  EXPECT_LT(most_refined_samples, 600U);
  EXPECT_GT(most_refined, 900U);
  EXPECT_EQ(scratch.refine.num_samples, 0U);
}

// A peg of few samples in a hole wider by c, its axis shifted by e (closed form: FieldWalk.AFewPointsIntegrate*). The
// contact is a few samples wide, and the whole free side is nearer than they are to each other.
TEST(RefineContact, ResolvesTheRimOfAConformingContactOfFewSamples) {
  constexpr double R = 0.01;
  constexpr double c = 5e-5;
  constexpr double L = 0.03;
  const DistanceField field = *BuildField(MakeBlockWithHole(0.04, L, R + c, 256), 2.5e-4);
  const SampleTree peg = BuildSampleTree(*SampleSurface(MakeCylinder(R, 0.04, 256), 8192));
  FastPairScratch scratch(peg);
  PairResult result;
  for (const double e : {6.5e-5, 8e-5, 1.2e-4}) {
    const double phi = std::acos(c / e);
    const double force = R * L * (e * (phi + std::sin(phi) * std::cos(phi)) - 2.0 * c * std::sin(phi));
    const core::Pose X_GS = At(e, 0.0, 0.0);
    QueryFastPair(peg, field, X_GS, X_GS, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
    EXPECT_NEAR(glm::length(scratch.force_m3) / force, 1.0, 0.01) << e;
  }
}

// An edge of L (the field) presses d into a plate, turned by a about the edge, and cuts a strip of W = d / sin cos of
// its face. Depth there is that to the nearer of the faces that meet at the edge, min(x sin, (W - x) cos): its integral
// is W^2 sin cos / 2 (sin + cos). The strip is two samples wide and crosses hundreds: all of them integrate it better
// than the finer points of some.
TEST(RefineContact, DoesNotCorrectAStripOfManySamples) {
  constexpr double kLength_m = 0.4;
  constexpr double kTurn = 0.1;
  constexpr double kHalf_m = 0.01;
  const DistanceField field = *BuildField(MakeBox({kLength_m, 2.0 * kHalf_m, 2.0 * kHalf_m}), 1e-3);
  SampleTree samples = BuildSampleTree(*SampleSurface(MakeBox({0.42, 0.03, 0.005}), 16384));
  const double spacing_m = std::sqrt(samples.area_m2 / samples.num_points);
  FastPairScratch scratch(samples);
  PairResult result;
  const auto mean_error = [&] {
    double sum = 0.0;
    constexpr int kPlaces = 24;
    for (int i = 0; i < kPlaces; ++i) {
      const double W = (2.0 + 0.04 * i) * spacing_m;
      const double d = W * std::sin(kTurn) * std::cos(kTurn);
      const double exact = kLength_m * W * d / (2.0 * (std::sin(kTurn) + std::cos(kTurn)));
      const core::Pose X_SE = At(0.0, 1e-3 + 1.3e-4 * i, -0.0025 + d, {kTurn, 0.0, 0.0});
      const core::Pose X_GS = (X_SE * At(0.0, -kHalf_m, -kHalf_m)).inverse();
      QueryFastPair(samples, field, X_GS, X_GS, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
      sum += std::pow(glm::length(scratch.force_m3) / exact - 1.0, 2);
    }
    return std::sqrt(sum / kPlaces);
  };
  const double error = mean_error();
  EXPECT_GT(scratch.refine.num_samples, 0U);
  samples.fine = {};
  EXPECT_LT(error, 1.2 * mean_error());
  EXPECT_LT(error, 0.03);
}

// Above its limit of samples the walk's sums are unchanged.
TEST(RefineContact, DoesNotRefineBroadContacts) {
  const DistanceField field = *BuildField(MakeBox({0.06, 0.06, 0.02}), 1e-3);
  const SampleTree samples = BuildSampleTree(*SampleSurface(MakeBox({0.03, 0.03, 0.02}), 16384));
  const core::Pose X_GS = At(0.001, 0.002, 0.02 - 2e-4);
  FastPairScratch scratch(samples);
  PairResult result;
  QueryFastPair(samples, field, X_GS, X_GS, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
  FieldWalkScratch walk(samples);
  const glm::dvec3 force = WalkField(samples, field, X_GS, WalkMargin_m(samples, 0.0), &walk).force_m3;
  EXPECT_EQ(scratch.refine.num_samples, 0U);
  EXPECT_EQ(scratch.force_m3, force);
}

}  // namespace
}  // namespace vps
