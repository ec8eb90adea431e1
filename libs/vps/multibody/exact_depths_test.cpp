#include "vps/multibody/exact_depths.hpp"

#include <gtest/gtest.h>

#include "vps/field/build_field.hpp"
#include "vps/field/pack_facets.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/contact_wrench.hpp"
#include "vps/testing/rough_torus.hpp"

namespace vps {
namespace {

constexpr double kVoxel_m = 1e-3;
constexpr double kRough_m = 6e-5;

core::Pose At(double x, double y, double z, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(turn), {x, y, z}};
}

double Random(std::uint32_t* seed) {
  *seed = *seed * 1664525U + 1013904223U;
  return (*seed >> 8) / 16777216.0;
}

// Groups of sixteen neighbouring places within 0.6 voxel of the surface, with their depths by the field.
std::vector<FacetPoints> PlacesNear(const TriangleMesh& mesh, const DistanceField& field, int count) {
  std::vector<FacetPoints> groups;
  const FieldTransform T(core::Pose{}, field);
  std::uint32_t seed = 3;
  for (int i = 0; i < count; ++i) {
    const auto [a, b, c] =
        mesh.corners(static_cast<std::size_t>(Random(&seed) * static_cast<double>(mesh.triangles.size())));
    const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a));
    const glm::dvec3 u(Random(&seed), Random(&seed), Random(&seed));
    const glm::dvec3 middle = (a * u.x + b * u.y + c * u.z) / (u.x + u.y + u.z) + kVoxel_m * (Random(&seed) - 0.6) * n;
    FacetPoints group;
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const glm::vec3 p(middle + 0.2 * kVoxel_m * glm::dvec3(Random(&seed), Random(&seed), Random(&seed)));
      group.x[k] = p.x;
      group.y[k] = p.y;
      group.z[k] = p.z;
      group.depth[k] = -SampleField(field, T.ToVoxels(p)).distance;
    }
    groups.push_back(group);
  }
  return groups;
}

struct Misses {
  double most = 0.0;
  int many = 0;  // of more than 0.003 voxel
};
Misses MissesOf(const std::vector<FacetPoints>& groups, const oracle::MeshDistance& exact) {
  Misses misses;
  for (const FacetPoints& group : groups) {
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const double depth = -exact.SignedDistance(glm::dvec3(group.x[k], group.y[k], group.z[k])) / kVoxel_m;
      const double miss = std::abs(static_cast<double>(group.depth[k]) - depth);
      misses.most = std::max(misses.most, miss);
      misses.many += miss > 3e-3 ? 1 : 0;
    }
  }
  return misses;
}

// Corners are rounded to 1/512 voxel, along each axis by half of that at most.
TEST(Facets, GiveTheExactDistance) {
  const TriangleMesh rough = MakeRoughTorus(kRough_m);
  const TriangleMesh box = MakeBox({0.2, 0.15, 0.01});  // longer than a block reaches
  for (const TriangleMesh* mesh : {&rough, &box}) {
    const DistanceField field = *BuildField(*mesh, kVoxel_m);
    ASSERT_FALSE(field.facets.blocks.empty());
    const oracle::MeshDistance exact(*mesh);
    std::vector<FacetPoints> groups = PlacesNear(*mesh, field, 500);
    const Misses before = MissesOf(groups, exact);
    FacetScratch scratch;
    ComputeExactDepths(field, {}, BestInstructionSet(), groups, &scratch);
    const Misses after = MissesOf(groups, exact);
    if (mesh == &rough) {
      EXPECT_GT(before.many, 3000);
    }
    EXPECT_LE(after.many, 8);  // of 8000: beside a corner where the sides of three faces or more do not agree
    EXPECT_LE(after.most, before.most);
  }
}

TEST(Facets, EveryInstructionSetGivesTheSame) {
  const TriangleMesh mesh = MakeRoughTorus(kRough_m);
  const DistanceField field = *BuildField(mesh, kVoxel_m);
  const std::vector<FacetPoints> groups = PlacesNear(mesh, field, 200);
  const core::Pose X_GS = At(1e-4, -2e-4, 1e-4, {0.001, 0.002, 0.0});
  FacetScratch scratch;
  std::vector<FacetPoints> portable = groups;
  ComputeExactDepths(field, X_GS, InstructionSet::kPortable, portable, &scratch);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!IsAvailable(set)) continue;
    std::vector<FacetPoints> other = groups;
    ComputeExactDepths(field, X_GS, set, other, &scratch);
    for (std::size_t i = 0; i < groups.size(); ++i) {
      for (std::uint32_t k = 0; k < kBlock; ++k) EXPECT_NEAR(other[i].depth[k], portable[i].depth[k], 1e-5f);
    }
  }
}

// So that the force does not change when points come and go.
TEST(Facets, APointsDepthDoesNotDependOnThePointsBesideIt) {
  const TriangleMesh mesh = MakeRoughTorus(kRough_m);
  const DistanceField field = *BuildField(mesh, kVoxel_m);
  const std::vector<FacetPoints> groups = PlacesNear(mesh, field, 200);
  FacetScratch scratch;
  std::vector<FacetPoints> together = groups;
  ComputeExactDepths(field, {}, BestInstructionSet(), together, &scratch);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    FacetPoints alone = groups[i];
    for (std::uint32_t k = 1; k < kBlock; ++k) {
      alone.x[k] = alone.x[0];
      alone.y[k] = alone.y[0];
      alone.z[k] = alone.z[0];
      alone.depth[k] = alone.depth[0];
    }
    ComputeExactDepths(field, {}, BestInstructionSet(), {&alone, 1}, &scratch);
    EXPECT_NEAR(alone.depth[0], together[i].depth[0], 1e-5f);
  }
}

TEST(Facets, AreKeptWhereTheyAreFew) {
  const TriangleMesh mesh = MakeRoughTorus(kRough_m);
  EXPECT_TRUE(BuildField(mesh, 8e-3)->facets.blocks.empty());
  for (const double voxel_m : {kVoxel_m, 4e-3}) {
    const DistanceField field = *BuildField(mesh, voxel_m);
    EXPECT_FALSE(field.facets.blocks.empty());
    EXPECT_LT(field.facets.num_bytes(), 22.0 * static_cast<double>(mesh.triangles.size()));
    EXPECT_LE(static_cast<double>(field.facets.num_bytes()),
              kMostFacetsShare / (1.0 + kMostFacetsShare) * static_cast<double>(field.num_bytes()));
  }
  // Facets several voxels wide are worth a hundredth of the field at most.
  EXPECT_TRUE(BuildField(mesh, 0.3 * kVoxel_m)->facets.blocks.empty());
}

// A ball lies a twentieth of a millimetre deep on a ring whose facets are 1 mm large, or so.
struct BallOnRoughRing {
  explicit BallOnRoughRing(double voxel_m = kVoxel_m) : field(*BuildField(ring, voxel_m)) {}
  TriangleMesh ring = MakeRoughTorus(kRough_m);
  TriangleMesh ball = MakeSphere(0.02, 192);
  DistanceField field;
  SampleTree samples = *BuildSampleTree(ball, 4096);
  FastPairScratch scratch{samples};
  PairDescription pair{.look_ahead_m = 0.0};
  PairResult result;

  // On the ring's outer side, at an angle.
  static core::Pose Pressed(double depth_m, double angle) {
    const double r = 0.03 + 0.012 + 0.02 - depth_m;
    return At(r * std::cos(angle), r * std::sin(angle), 5e-4, {0.3, 0.2 * angle, 0.1});
  }
  glm::dvec3 Force(const core::Pose& X_GS) {
    QueryFastPair(samples, field, X_GS, X_GS, pair, 0.01, &scratch, &result);
    return X_GS.rotate(scratch.force_m3);
  }
};

// With few finer points the force depends on where they happen to lie; with larger voxels fewer facets are near.
TEST(ExactDepths, IntegrateAShallowContactOnRoughFacets) {
  struct Case {
    double voxel_m, most;
  };
  for (const auto& [voxel_m, most] : {Case{kVoxel_m, 0.4}, Case{2.0 * kVoxel_m, 0.6}}) {
    BallOnRoughRing pair(voxel_m);
    const oracle::MeshDistance A(pair.ring);
    const oracle::MeshDistance B(pair.ball);
    const auto worst_of = [&] {
      double worst = 0.0;
      for (int i = 0; i < 8; ++i) {
        const core::Pose X = BallOnRoughRing::Pressed(5e-5, 0.7 * i);
        const glm::dvec3 truth = oracle::IntegrateContactWrench(A, B, X, {1e-3}).force_A_m3;
        worst = std::max(worst, glm::length(pair.Force(X) - truth) / glm::length(truth));
      }
      return worst;
    };
    const double with = worst_of();
    pair.field.facets = {};
    const double without = worst_of();
    EXPECT_LT(with, most);
    EXPECT_GT(without, 2.0 * with);
  }
}

TEST(ExactDepths, AreUsedForTheDeepestPoint) {
  BallOnRoughRing pair;
  const oracle::MeshDistance A(pair.ring);
  int num_contacts = 0;
  float worst_of_field = 0.0f;
  for (int i = 0; i < 16; ++i) {
    const core::Pose X = BallOnRoughRing::Pressed(5e-5, 0.35 * i);
    pair.Force(X);
    if (!(pair.result.signed_distance_m < 0.0)) continue;
    ++num_contacts;
    const glm::vec3 p_S = pair.result.deepest_p_S;
    const double exact_m = A.SignedDistance(X * glm::dvec3(p_S));
    EXPECT_NEAR(pair.result.signed_distance_m, exact_m, 2e-3 * kVoxel_m) << i;  // facets are kept to 1e-3
    const float field = SampleField(pair.field, FieldTransform(X, pair.field).ToVoxels(p_S)).distance;
    worst_of_field = std::max(worst_of_field, std::abs(field - static_cast<float>(exact_m / kVoxel_m)));
  }
  EXPECT_GT(num_contacts, 8);
  EXPECT_GT(worst_of_field, 0.01f);
}

// Not where the contact is deep against the field's error, nor where the field has none, nor where there are no facets.
TEST(ExactDepths, AreUsedWhereTheFieldHasErrors) {
  BallOnRoughRing pair;
  pair.Force(BallOnRoughRing::Pressed(5e-5, 0.35));
  EXPECT_EQ(pair.scratch.refine.share_of_exact, 1.0f);
  pair.Force(BallOnRoughRing::Pressed(2e-3, 0.35));
  EXPECT_EQ(pair.scratch.refine.share_of_exact, 0.0f);
  pair.Force(BallOnRoughRing::Pressed(3e-4, 0.35));
  EXPECT_GT(pair.scratch.refine.error, 0.01f);
  EXPECT_GT(pair.scratch.refine.share_of_small, 0.0f);
  pair.field.facets = {};
  pair.Force(BallOnRoughRing::Pressed(3e-4, 0.35));
  EXPECT_EQ(pair.scratch.refine.error, 0.0f);
  EXPECT_EQ(pair.scratch.refine.share_of_small, 0.0f);
  pair.field = *BuildField(MakeBox({0.084, 0.084, 0.04}), kVoxel_m);
  pair.Force(At(0.0, 0.0, 0.02 + 0.02 - 5e-5));
  EXPECT_GT(pair.scratch.refine.share_of_small, 0.0f);
  EXPECT_EQ(pair.scratch.refine.share_of_exact, 0.0f);
}

// From the first touch until so many points are in contact that the field alone is used.
TEST(ExactDepths, ForceIsContinuous) {
  BallOnRoughRing pair;
  glm::dvec3 before(0.0);
  float share_before = 0.0f;
  float exact_before = 0.0f;
  for (int i = 0; i <= 650; ++i) {
    const double depth_m = -5e-5 + 1e-6 * i;
    const glm::dvec3 force = pair.Force(BallOnRoughRing::Pressed(depth_m, 0.7));
    // The area in contact grows with the depth: pi 2 R d, with R = R1 R2 / (R1 + R2) of the two rounds.
    const double area_m2 = M_PI * 2.0 * 0.0075 * (std::max(depth_m, 0.0) + 2.0 * kRough_m);
    if (i > 0) {
      EXPECT_LT(glm::length(force - before), 4.0 * 1e-6 * area_m2) << i;
    }
    // Nor do the shares of the methods.
    const RefineScratch& refine = pair.scratch.refine;
    if (refine.num_near > 10.0f) {
      EXPECT_LT(std::abs(refine.share_of_small - share_before), 0.2f) << i;
      EXPECT_LT(std::abs(refine.share_of_exact - exact_before), 0.2f) << i;
    }
    share_before = refine.share_of_small;
    exact_before = refine.share_of_exact;
    before = force;
  }
  EXPECT_GT(glm::length(before), 0.0);
  EXPECT_EQ(share_before, 0.0f);
  EXPECT_EQ(exact_before, 0.0f);
}

}  // namespace
}  // namespace vps
