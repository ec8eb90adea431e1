#include "vps/multibody/small_contact.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "vps/field/build_field.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/contact_wrench.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

constexpr double kVoxel_m = 1e-3;

core::Pose At(double x, double y, double z, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(turn), {x, y, z}};
}

double Random(std::uint32_t* seed) {
  *seed = *seed * 1664525U + 1013904223U;
  return (*seed >> 8) / 16777216.0;
}

// Something on a plate whose upper face is z = 0.
struct OnPlate {
  explicit OnPlate(const TriangleMesh& mesh, std::uint32_t num_points)
      : part(mesh), samples(*BuildSampleTree(mesh, num_points)), scratch(samples) {}

  TriangleMesh plate = MakeBox({0.1, 0.1, 0.02});
  TriangleMesh part;
  DistanceField field = *BuildField(plate, kVoxel_m);
  SampleTree samples;
  FastPairScratch scratch;
  PairDescription pair{.look_ahead_m = 0.0};
  PairResult result;

  glm::dvec3 Force(const core::Pose& X_GS) {
    QueryFastPair(samples, field, X_GS, X_GS, pair, 0.01, &scratch, &result);
    return X_GS.rotate(scratch.force_m3);
  }
};

constexpr double kSurface_m = 0.01;  // MakeBox is centred

// The lowest corner of a turned cube.
core::Pose OnItsCorner(double size_m, double depth_m, std::uint32_t* seed) {
  const glm::dvec3 turn(0.6 + 0.3 * Random(seed), 0.5 + 0.3 * Random(seed), 0.4 * Random(seed));
  const core::Pose X = At(3e-3 * Random(seed), 3e-3 * Random(seed), 0.0, turn);
  double lowest_m = 0.0;
  for (int k = 0; k < 8; ++k) {
    const glm::dvec3 corner = 0.5 * size_m * glm::dvec3((k & 1) * 2 - 1, (k & 2) - 1, (k & 4) / 2 - 1);
    lowest_m = std::min(lowest_m, X.rotate(corner).z);
  }
  return {X.rotation, X.translation + glm::dvec3(0.0, 0.0, kSurface_m - lowest_m - depth_m)};
}

// Two hundredths of a voxel deep: the surface of two samples.
TEST(SmallContact, IntegratesAContactOfTwoSamples) {
  constexpr double kRadius_m = 0.02;
  OnPlate pair(MakeSphere(kRadius_m, 96), 4096);
  ASSERT_FALSE(pair.samples.pieces.pieces.empty());
  const oracle::MeshDistance A(pair.plate);
  const oracle::MeshDistance B(pair.part);
  const auto worst_of = [&] {
    double worst = 0.0;
    std::uint32_t seed = 5;
    for (int i = 0; i < 16; ++i) {
      const glm::dvec3 turn(6.0 * Random(&seed), 6.0 * Random(&seed), 6.0 * Random(&seed));
      const core::Pose X = At(3e-3 * Random(&seed), 3e-3 * Random(&seed), kSurface_m + kRadius_m - 2.5e-5, turn);
      const glm::dvec3 truth = oracle::IntegrateContactWrench(A, B, X, {1e-3}).force_A_m3;
      worst = std::max(worst, glm::length(pair.Force(X) - truth) / glm::length(truth));
    }
    return worst;
  };
  EXPECT_LT(worst_of(), 0.03);
  pair.samples.pieces = {};
  EXPECT_GT(worst_of(), 0.06);
}

TEST(SmallContact, FindsTheDeepestPointOfACorner) {
  constexpr double kSize_m = 0.04;
  OnPlate pair(MakeBox(glm::dvec3(kSize_m)), 4096);
  std::uint32_t seed = 9;
  for (int i = 0; i < 8; ++i) {
    const core::Pose X = OnItsCorner(kSize_m, 3e-4, &seed);
    pair.Force(X);
    EXPECT_TRUE(pair.result.is_in_contact);
    EXPECT_NEAR(pair.result.signed_distance_m, -3e-4, 6e-5);
    const glm::dvec3 p_S(pair.result.deepest_p_S);
    EXPECT_NEAR((X * p_S).z - kSurface_m, pair.result.signed_distance_m, 1e-7);
    EXPECT_NEAR(glm::dot(p_S, glm::dvec3(pair.result.deepest_n_S)), -0.5 * kSize_m, 1e-7);  // on a face
  }
}

// A ball comes down on a plate: its force is the volume of its cap, pi d^2 (R - d / 3), and grows by its circle's area,
// through all sizes of pieces and until the samples alone are used.
TEST(SmallContact, ForceIsContinuous) {
  constexpr double kRadius_m = 0.02;
  OnPlate pair(MakeSphere(kRadius_m, 192), 16384);
  double before = 0.0;
  int num_small = 0;
  int num_others = 0;
  for (int i = 0; i <= 500; ++i) {
    const double d = -1e-4 + 1e-6 * i;
    const core::Pose X = At(2e-4, 3e-4, kSurface_m + kRadius_m - d, {0.3, 0.2, 0.1});
    const double force = glm::length(pair.Force(X));
    (pair.scratch.refine.share_of_small > 0.0f ? num_small : num_others) += 1;
    // The ball's facets lie up to 3 um inside the ball.
    const double area_m2 = 2.0 * std::numbers::pi * kRadius_m * (std::max(d, 0.0) + 1e-5);
    if (i > 0) {
      EXPECT_LT(std::abs(force - before), 2.0 * 1e-6 * area_m2) << d;
    }
    EXPECT_EQ(pair.result.is_in_contact, pair.result.signed_distance_m < 0.0) << d;
    EXPECT_TRUE(pair.result.is_in_contact || force == 0.0) << d;
    before = force;
  }
  EXPECT_GT(num_small, 60);
  EXPECT_GT(num_others, 50);
}

// A cube comes down on its corner. With the plate's normal n in the cube's frame, the sides inside are d / n_i long and
// the mean depth of the triangles is d / 3: their forces add up to d^3 / (6 n_x n_y n_z) along n. First the corner is
// smaller than the samples resolve; then it is deep, and the samples take over.
TEST(SmallContact, ForceOfACornerIsContinuous) {
  constexpr double kSize_m = 0.04;
  constexpr double kStep_m = 2e-6;
  struct Way {
    std::uint32_t num_points;
    double begin_m, end_m;
    float share_at_begin, share_at_end;
  };
  for (const Way& way : {Way{512, 0.0, 6e-4, 0.0f, 1.0f}, Way{2048, 1.1e-3, 2.1e-3, 1.0f, 0.0f}}) {
    OnPlate pair(MakeBox(glm::dvec3(kSize_m)), way.num_points);
    double before = 0.0;
    const int num_steps = static_cast<int>(std::lround((way.end_m - way.begin_m) / kStep_m));
    for (int i = 0; i <= num_steps; ++i) {
      const double d = way.begin_m + kStep_m * i;
      std::uint32_t seed = 9;
      const core::Pose X = OnItsCorner(kSize_m, d, &seed);
      const double n3 = std::abs(X.rotate({1, 0, 0}).z * X.rotate({0, 1, 0}).z * X.rotate({0, 0, 1}).z);
      const double force = glm::length(pair.Force(X));
      if (i == 0) {
        EXPECT_EQ(pair.scratch.refine.share_of_small, way.share_at_begin);
      } else {
        EXPECT_LE(std::abs(force - before), 4.0 * kStep_m * d * d / (2.0 * n3)) << d;
      }
      before = force;
      if (i < num_steps) continue;
      EXPECT_EQ(pair.scratch.refine.share_of_small, way.share_at_end);
      EXPECT_NEAR(force * 6.0 * n3 / (d * d * d), 1.0, 0.02);
    }
  }
}

struct BeamOnPlate : OnPlate {
  BeamOnPlate(double tilt_rad, std::uint32_t num_points)
      : OnPlate(MakeBox({kLength_m, kWidth_m, kWidth_m}), num_points), tilt(tilt_rad) {}
  // On its edge.
  [[nodiscard]] core::Pose Pressed(double depth_m) const {
    const double half_height_m = 0.5 * kWidth_m * (std::sin(tilt) + std::cos(tilt));
    return At(2e-4, 3e-4, kSurface_m + half_height_m - depth_m, {tilt, 0.0, 0.0});
  }
  static constexpr double kLength_m = 0.09;
  static constexpr double kWidth_m = 0.02;
  double tilt;
};

// The force is L d^2 / (2 sin cos) of the tilt, until so many samples are near that they alone are used.
TEST(SmallContact, ForceOfAnEdgeIsContinuous) {
  constexpr double kStep_m = 1e-6;
  for (const std::uint32_t num_samples : {9000U, 16384U}) {
    BeamOnPlate pair(0.3, num_samples);
    const double area_per_m = BeamOnPlate::kLength_m / (std::sin(pair.tilt) * std::cos(pair.tilt));
    double before = 0.0;
    int num_small = 0;
    int num_others = 0;
    for (int i = 0; i <= 150; ++i) {
      const double d = kStep_m * i;
      const double force = glm::length(pair.Force(pair.Pressed(d)));
      (pair.scratch.refine.share_of_small > 0.0f ? num_small : num_others) += 1;
      EXPECT_LE(std::abs(force - before), 2.0 * kStep_m * area_per_m * d) << d;
      before = force;
    }
    EXPECT_GT(num_small, 50) << num_samples;
    EXPECT_GT(num_others, 25) << num_samples;
  }
}

// Deeper than that the finer points of some of the samples represent all that are near.
TEST(SmallContact, IsNotUsedForADeepLongEdge) {
  BeamOnPlate pair(0.3, 16384);
  const auto worst_of = [&] {
    double worst = 0.0;
    for (const double d : {9e-5, 1e-4, 1.1e-4}) {
      const double exact = BeamOnPlate::kLength_m * d * d / (2.0 * std::sin(pair.tilt) * std::cos(pair.tilt));
      worst = std::max(worst, std::abs(glm::length(pair.Force(pair.Pressed(d))) / exact - 1.0));
      EXPECT_EQ(pair.scratch.refine.share_of_small, 0.0f);
    }
    return worst;
  };
  EXPECT_LT(worst_of(), 0.05);
  EXPECT_GT(pair.scratch.refine.num_represented, 3.0f);
  BeamOnPlate few(0.3, 4096);
  few.Force(few.Pressed(1.1e-4));
  EXPECT_NEAR(few.scratch.refine.num_represented, 1.0f, 1e-5f);
  EXPECT_NEAR(pair.scratch.refine.near_m2 / few.scratch.refine.near_m2, 1.0f, 0.2f);
  pair.samples.fine = {};
  EXPECT_GT(worst_of(), 0.1);
}

// A twentieth of a voxel deep, a strip narrower than the finer points of its samples are apart: they miss a third.
TEST(SmallContact, IntegratesANarrowStripAlongAnEdge) {
  for (const std::uint32_t num_samples : {4096U, 16384U}) {
    BeamOnPlate pair(0.4, num_samples);
    const auto worst_of = [&] {
      double worst = 0.0;
      for (const double d : {3e-5, 4e-5, 6e-5, 9e-5}) {
        const double exact = BeamOnPlate::kLength_m * d * d / (2.0 * std::sin(pair.tilt) * std::cos(pair.tilt));
        worst = std::max(worst, std::abs(glm::length(pair.Force(pair.Pressed(d))) / exact - 1.0));
        EXPECT_NEAR(pair.result.signed_distance_m, -d, 5e-6);
      }
      return worst;
    };
    EXPECT_LT(worst_of(), 0.15) << num_samples;
    pair.samples.pieces = {};
    if (num_samples > 8192) pair.samples.fine = {};  // there they are near enough to each other
    EXPECT_GT(worst_of(), 0.4) << num_samples;
  }
}

// More pieces may be inside than there is room for: of a face just above a plate, or farther above it, where none is in
// the end; along an edge that is cut finely. The samples' result is kept.
TEST(SmallContact, KeepsTheSamplesResultWhereTooManyPiecesAreNear) {
  BeamOnPlate beam(0.4, 4096);
  const SurfacePieces block = CutIntoPieces(MakeBox({0.09, 0.09, 0.01}), 1e-3);
  SmallContact small;
  for (const double gap_m : {5e-5, 2e-4}) {
    const core::Pose X = At(0.0, 0.0, kSurface_m + 0.005 + gap_m);
    EXPECT_FALSE(small.Integrate(block, beam.field, X, {.spacing_m = 5e-4})) << gap_m;
  }
  beam.samples.pieces = CutIntoPieces(beam.part, 5e-4);
  ASSERT_FALSE(beam.samples.pieces.pieces.empty());
  const core::Pose X = beam.Pressed(5e-5);
  const glm::dvec3 force = beam.Force(X);
  EXPECT_EQ(beam.scratch.refine.share_of_small, 1.0f);
  EXPECT_GT(glm::length(force), 0.0);
  beam.samples.pieces = {};
  EXPECT_EQ(force, beam.Force(X));
}

// The face of a block comes towards a plate, even or turned a little. Its edges' finer points are few, but all of the
// face is so near that there would be more pieces than there is room for.
TEST(SmallContact, IsNotUsedForAnApproachingFace) {
  const DistanceField plate = *BuildField(MakeBox({0.1, 0.1, 2.0 * kSurface_m}), kVoxel_m);
  const SampleTree samples = *BuildSampleTree(MakeBox({0.09, 0.08, 0.02}), 65536);
  FastPairScratch scratch(samples);
  PairResult result;
  std::uint32_t most_refined_samples = 0;
  for (const double turn : {0.0, 0.003}) {
    const double lowest_m = 0.01 * std::cos(turn) + 0.04 * std::sin(turn);
    for (int i = 0; i < 70; ++i) {
      const double gap_m = 2e-6 * i;
      const core::Pose X = At(2e-4, 3e-4, kSurface_m + lowest_m + gap_m, {turn, 0.0, 0.0});
      QueryFastPair(samples, plate, X, X, {.look_ahead_m = 0.0}, 0.01, &scratch, &result);
      EXPECT_EQ(scratch.refine.share_of_small, 0.0f) << turn << ", " << gap_m;
      most_refined_samples = std::max(most_refined_samples, scratch.refine.num_samples);
    }
  }
  EXPECT_GT(most_refined_samples, 100U);
}

TEST(SphereSieve, KeepsEverySphereWithAPlaceInside) {
  const TriangleMesh mesh = MakeBlockWithHole(0.05, 0.05, 0.01, 64);
  const DistanceField field = *BuildField(mesh, kVoxel_m);
  const oracle::MeshDistance exact(mesh);
  const core::Pose X_GS = At(1e-3, -2e-3, 5e-4, {0.2, 0.1, 0.3});
  SphereSieve sieve(field, X_GS);
  std::uint32_t seed = 7;
  int num_left_out = 0;
  for (int i = 0; i < 2000; ++i) {
    SphereBlock block;
    unsigned inside = 0;
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const glm::vec3 centre(0.06 * (Random(&seed) - 0.5), 0.06 * (Random(&seed) - 0.5), 0.02 * (Random(&seed) - 0.5));
      const glm::vec3 u = glm::normalize(glm::vec3(Random(&seed) - 0.5, Random(&seed) - 0.5, Random(&seed) - 0.5));
      const glm::vec3 v = glm::normalize(glm::cross(u, glm::vec3(0.3f, 0.5f, 0.8f)));
      const auto size = static_cast<float>(6e-3 * Random(&seed));
      const glm::vec3 corners[3] = {centre + size * u, centre - size * u, centre + size * v};
      PutSphere(corners, centre, glm::normalize(glm::cross(u, v)), k, &block);
      for (int n = 0; n < 10; ++n) {
        const auto a = static_cast<float>(Random(&seed));
        const auto b = static_cast<float>(Random(&seed)) * (1.0f - a);
        const glm::vec3 p = corners[0] + a * (corners[1] - corners[0]) + b * (corners[2] - corners[0]);
        if (exact.SignedDistance(X_GS * glm::dvec3(p)) < 0.0) inside |= 1U << k;
      }
    }
    const unsigned found = sieve.MayBeInside(block);
    EXPECT_EQ(inside & ~found, 0U);
    num_left_out += 16 - __builtin_popcount(found);
  }
  EXPECT_GT(num_left_out, 5000);
}

}  // namespace
}  // namespace vps
