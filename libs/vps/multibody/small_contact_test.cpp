#include "vps/multibody/small_contact.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "vps/field/build_field.hpp"
#include "vps/mesh/shapes.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/contact_wrench.hpp"

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
TEST(SmallContact, TellsABarePressureThatSamplesTellByChance) {
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

TEST(SmallContact, TellsTheDeepestPlaceOfACorner) {
  constexpr double kSize_m = 0.04;
  OnPlate pair(MakeBox(glm::dvec3(kSize_m)), 4096);
  std::uint32_t seed = 9;
  for (int i = 0; i < 8; ++i) {
    const core::Pose X = OnItsCorner(kSize_m, 3e-4, &seed);
    pair.Force(X);
    EXPECT_TRUE(pair.result.is_in_contact);
    EXPECT_NEAR(pair.result.signed_distance_m, -3e-4, 6e-5);
    EXPECT_LT((X * glm::dvec3(pair.result.deepest_p_S)).z, kSurface_m);
  }
}

// A ball comes down on a plate: its force is the volume of its cap, pi d^2 (R - d / 3), and grows by its circle's area,
// through all sizes of pieces and until the samples tell it.
TEST(SmallContact, ForceHasNoSteps) {
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
  EXPECT_GT(num_small, 100);
  EXPECT_GT(num_others, 50);
}

// A face a hair above a plate: more pieces than there is room for. The samples' answer stands.
TEST(SmallContact, LeavesWhatIsNearEverywhereToTheSamples) {
  const TriangleMesh block = MakeBox({0.09, 0.09, 0.01});
  OnPlate pair(block, 65536);
  SmallContact small;
  const core::Pose X = At(0.0, 0.0, kSurface_m + 0.005 + 5e-5);
  EXPECT_FALSE(small.Integrate(pair.samples.pieces, pair.field, X, 5e-4, 0.0));
  const glm::dvec3 force = pair.Force(At(0.0, 0.0, kSurface_m + 0.005 - 5e-5, {1e-3, 0.0, 0.0}));
  pair.samples.pieces = {};
  EXPECT_EQ(force, pair.Force(At(0.0, 0.0, kSurface_m + 0.005 - 5e-5, {1e-3, 0.0, 0.0})));
}

TEST(SphereSieve, LeavesOutNothingThatIsInside) {
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
