#include <gtest/gtest.h>

#include <map>
#include <set>

#include "vps/asset/cooked_object.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/testing/contact_cases.hpp"
#include "vps/testing/part_shapes.hpp"

namespace vps {
namespace {

struct PairWithPlanes {
  PairWithPlanes(const TriangleMesh& A, const TriangleMesh& B, double voxel_size_m, std::uint32_t num_points)
      : G(*Cook(A, {voxel_size_m, 0, Method::kFast})),
        S(*Cook(B, {0.0, num_points, Method::kFast})),
        scratch(*S.samples) {
    pair.look_ahead_m = 5e-4;
  }
  const PairResult& Query(const core::Pose& X_AB) {
    QueryFastPair(FastPairOf(S, G), X_AB, X_AB, pair, 0.01, &scratch, &result);
    return result;
  }
  CookedObject G, S;
  FastPairScratch scratch;
  PairDescription pair;
  PairResult result;
};

// Wrench of the planes at this pose, on B about its mesh origin, in A.
core::Wrench WrenchOf(const ContactPlanes& planes, const core::Pose& X_AB) {
  core::Wrench sum;
  for (const core::ContactPlane& plane : planes) {
    const glm::dvec3 n(plane.n_G);
    const glm::dvec3 p_A = X_AB * glm::dvec3(plane.p_S);
    const double gap = glm::dot(n, p_A - glm::dvec3(plane.q_G));
    if (gap >= 0.0) continue;
    const glm::dvec3 force = -gap * static_cast<double>(plane.stiffness_N_per_m) * n;
    sum += core::Wrench{force, glm::cross(p_A - X_AB.translation, force)};
  }
  return sum;
}

// Also where more blocks are near than patches are reduced: none is left out.
TEST(ContactPlanes, AddUpToTheWrenchOfTheQuery) {
  for (const ContactCase& c : {BallCase(4), PegCase(4)}) {
    PairWithPlanes engine(c.A, c.B, c.voxel_size_m, 65536);
    const Box box = BoundingBox(c.B);
    const double size_m = glm::length(box.upper - box.lower);
    std::uint32_t most_blocks = 0;
    for (const core::Pose& X_AB : c.poses) {
      const PairResult& result = engine.Query(X_AB);
      if (!result.is_in_contact) continue;
      most_blocks = std::max(most_blocks, engine.scratch.found.num_near_blocks);
      const core::Wrench planes = WrenchOf(result.planes, X_AB);
      const double force = glm::length(result.F_So_W.force_N);
      EXPECT_LT(glm::length(planes.force_N - result.F_So_W.force_N), 1e-6 * force) << c.name;
      EXPECT_LT(glm::length(planes.torque_Nm - result.F_So_W.torque_Nm), 1e-6 * force * size_m) << c.name;
    }
    EXPECT_GT(most_blocks, kMaxNearPatches) << c.name;
  }
}

TEST(ContactPlanes, KeepTheWrenchWithinOnePercent) {
  for (const ContactCase& c : {BallCase(10), ToriCase(10), PegCase(10), *ModuleCase(VR_OOS_SOURCE_DIR, 14)}) {
    PairWithPlanes engine(c.A, c.B, c.voxel_size_m, 4096);
    const Box box = BoundingBox(c.B);
    const double size_m = glm::length(box.upper - box.lower);
    int num_touching = 0;
    for (const core::Pose& X_AB : c.poses) {
      const PairResult& result = engine.Query(X_AB);
      if (!result.is_in_contact) continue;
      ++num_touching;
      ASSERT_LE(result.planes.size(), 24U);
      const core::Wrench planes = WrenchOf(result.planes, X_AB);
      const double force = glm::length(result.F_So_W.force_N);
      EXPECT_LT(glm::length(planes.force_N - result.F_So_W.force_N), 0.01 * force) << c.name;
      EXPECT_LT(glm::length(planes.torque_Nm - result.F_So_W.torque_Nm), 0.01 * force * 0.25 * size_m) << c.name;
    }
    EXPECT_GE(num_touching, 5) << c.name;
  }
}

// A tongue in a groove with play, pressed on one wall. Its samples of both faces are neighbours, and many: the planes
// hold the other wall as well, or a blow would throw the tongue through it.
TEST(ContactPlanes, GuardTheFaceThatLooksAway) {
  constexpr double kPlay_m = 1e-4, kPressed_m = 1e-5, kThick_m = 1e-3;
  for (const std::uint32_t num_points : {4096U, 16384U, 65536U}) {
    PairWithPlanes engine(MakeTray({0.044, 0.004 + kThick_m + kPlay_m, 0.034}, 0.002),
                          MakeBox({0.039, kThick_m, 0.028}), 2.5e-4, num_points);
    for (const double side : {1.0, -1.0}) {
      const core::Pose X_AB{{1, 0, 0, 0}, {0.0, side * (0.5 * kPlay_m + kPressed_m), 0.002}};
      double most_depth_m = 0.0, least_gap_m = 1.0;
      for (const core::ContactPlane& plane : engine.Query(X_AB).planes) {
        const double gap_m = glm::dot(glm::dvec3(plane.n_G), X_AB * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
        if (side * plane.n_G.y < -0.9) most_depth_m = std::max(most_depth_m, -gap_m);
        if (side * plane.n_G.y > 0.9) least_gap_m = std::min(least_gap_m, gap_m);
      }
      EXPECT_GT(engine.scratch.found.num_near_blocks, kMaxNearPatches);
      EXPECT_NEAR(most_depth_m, kPressed_m, 1e-6) << num_points;
      EXPECT_NEAR(least_gap_m, kPlay_m + kPressed_m, 1e-6) << num_points;
    }
  }
}

// A box rocks on a plate: where its bottom is lifted, a plane is at the bottom's rim, and not at a place of the side
// above it, which is farther out but touches long after.
TEST(ContactPlanes, GuardTheRimOfAFaceThatIsLifted) {
  constexpr double kTurn_rad = 2e-4, kPressed_m = 1e-6;
  constexpr glm::dvec3 kSize_m(0.03, 0.04, 0.08);
  for (const std::uint32_t num_points : {2048U, 8000U, 32768U}) {
    PairWithPlanes engine(MakeBox({0.2, 0.2, 0.02}), MakeBox(kSize_m), 1e-3, num_points);
    for (const double side : {1.0, -1.0}) {
      const glm::dquat turn = core::QuaternionFromRotationVector({0.0, -side * kTurn_rad, 0.0});
      const double rim_m = 0.5 * kSize_m.x * kTurn_rad;
      const core::Pose X_AB{turn, {0.0, 0.0, 0.01 + 0.5 * kSize_m.z + rim_m - kPressed_m}};
      double least_gap_m = 1.0;
      for (const core::ContactPlane& plane : engine.Query(X_AB).planes) {
        if (side * plane.p_S.x < 0.1 * kSize_m.x) continue;
        const double gap_m = glm::dot(glm::dvec3(plane.n_G), X_AB * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
        least_gap_m = std::min(least_gap_m, gap_m);
      }
      EXPECT_LT(least_gap_m, 2.0 * rim_m) << num_points << ' ' << side;
    }
  }
}

// A block slides and turns on a plate, a ball rolls: of the planes that carry, hardly any changes its id.
TEST(ContactPlanes, IdsPersistWhileABodySlidesAndRolls) {
  const TriangleMesh plate = MakeBox({0.2, 0.2, 0.02});
  struct Ride {
    TriangleMesh mesh;
    double height_m;
    glm::dvec3 turn;
  };
  for (const Ride& ride : {Ride{MakeBox({0.02, 0.03, 0.01}), 0.015 - 2e-4, {0, 0, 1.0}},
                           Ride{MakeSphere(0.01, 96), 0.02 - 5e-4, {0, 3.0, 0}}}) {
    PairWithPlanes engine(plate, ride.mesh, 1e-3, 8192);
    std::set<std::uint32_t> before;
    int num_kept = 0;
    int num_lost = 0;
    for (int i = 0; i < 500; ++i) {
      const double t = 1e-3 * i;
      const core::Pose X{core::QuaternionFromRotationVector(t * ride.turn), {-0.03 + 0.1 * t, 0.01 * t, ride.height_m}};
      std::set<std::uint32_t> ids;
      for (const core::ContactPlane& plane : engine.Query(X).planes) {
        if (glm::dot(glm::dvec3(plane.n_G), X * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G)) < 0.0) {
          EXPECT_TRUE(ids.insert(plane.id).second);
        }
      }
      ASSERT_FALSE(ids.empty());
      for (const std::uint32_t id : before) ++(ids.contains(id) ? num_kept : num_lost);
      before = ids;
    }
    EXPECT_LT(num_lost, num_kept / 200);
  }
}

}  // namespace
}  // namespace vps
