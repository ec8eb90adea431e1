#include "vps/walk/walk_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "vps/field/build_field.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/flat_walk.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {
namespace {

struct Couple {
  DistanceField field;
  SampleTree points;
  core::Pose start;  // touching a little
};
const Couple& CoupleOfTori() {
  static const Couple couple{*BuildField(MakeTorus(0.05, 0.02, 48, 24), 0.001),
                             BuildSampleTree(*SampleSurface(MakeTorus(0.05, 0.02, 48, 24), 20000)),
                             {{1.0, 0.0, 0.0, 0.0}, {0.1395, 0.0, 0.0}}};
  return couple;
}

core::Pose MovedBy(const core::Pose& X, const glm::dvec3& shift_m, const glm::dvec3& turn) {
  return {glm::normalize(core::QuaternionFromRotationVector(turn) * X.rotation), X.translation + shift_m};
}

TEST(WalkMemory, FreeDistanceIsFree) {
  const Couple& couple = CoupleOfTori();
  FieldWalkMemory memory;
  FieldWalkScratch scratch(couple.points);
  scratch.memory = &memory;
  CaseRandom random(5);
  core::Pose X = MovedBy(couple.start, {0.012, 0.0, 0.0}, {});
  int num_free = 0;
  for (int i = 0; i < 2000; ++i) {
    X = MovedBy(X, glm::dvec3(-4e-6, 0.0, 0.0) + 4e-5 * random.InCube(), 4e-4 * random.InCube());
    const FieldWalkResult result = WalkField(couple.points, couple.field, X, 0.001, &scratch);
    if (result.num_near > 0) break;
    if (!(result.free_distance_m > 0.0)) continue;
    ++num_free;
    if (i % 20 != 0) continue;
    const core::Pose moved = MovedBy(X, 0.9999 * result.free_distance_m * glm::normalize(random.InCube()), {});
    ASSERT_EQ(WalkFieldFlat(couple.points, couple.field, moved, 0.001).num_near, 0U);
  }
  EXPECT_GT(num_free, 500);
}

// Distance of the points from the torus that Tori's mesh is inscribed in, by its formula.
double DistanceOfPoints_m(const SampleTree& points, const core::Pose& X_GS) {
  double least = 1e30;
  for (std::uint32_t i = 0; i < points.num_points; ++i) {
    const PointBlock& block = points.points[i / kBlock];
    const glm::dvec3 p = X_GS * glm::dvec3(block.x[i % kBlock], block.y[i % kBlock], block.z[i % kBlock]);
    least = std::min(least, std::hypot(std::hypot(p.x, p.y) - 0.05, p.z) - 0.02);
  }
  return least;
}

// Two rings 20 to 60 mm apart that drift and turn by half a millimetre a cycle.
TEST(WalkMemory, AFarPairIsSeldomWalkedAndNeverTooLate) {
  constexpr double kSag_m = 4e-4;  // of the mesh below the torus
  const Couple& couple = CoupleOfTori();
  FieldWalkMemory memory;
  FieldWalkScratch scratch(couple.points);
  scratch.memory = &memory;
  int num_walks = 0;
  double best = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const glm::dquat turn = core::QuaternionFromRotationVector(glm::dvec3(0.004 * i, 0.2, 0.003 * i));
    const glm::dvec3 place(0.19 * std::cos(0.002 * i), 0.19 * std::sin(0.002 * i), 0.03 * std::sin(0.01 * i));
    const FieldWalkResult result = WalkField(couple.points, couple.field, {turn, place}, 0.002, &scratch);
    ASSERT_EQ(result.num_near, 0U);
    ASSERT_GT(result.free_distance_m, 0.0);
    if (result.spheres_tested == 0 && i % 10 != 0) continue;
    num_walks += result.spheres_tested > 0 ? 1 : 0;
    const double distance_m = DistanceOfPoints_m(couple.points, {turn, place});
    ASSERT_LE(result.free_distance_m + 0.002, distance_m + kSag_m);
    best = std::max(best, (result.free_distance_m + 0.002) / distance_m);
  }
  EXPECT_LE(num_walks, 60);
  EXPECT_GT(best, 0.75);
}

TEST(WalkMemory, NoPointMovesFartherThanTheMotionBound) {
  CaseRandom random(6);
  double tightest = 1e30;
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10.0, -5.0 + (i % 6));
    const core::Pose before = MovedBy({}, random.InCube(), 3.0 * random.InCube());
    const core::Pose now = MovedBy(before, size * (i % 3 == 0 ? 0.0 : 1.0) * random.InCube(), size * random.InCube());
    const glm::dvec3 centre = 0.2 * random.InCube();
    const double bound = MotionBound(before, before * centre, now, centre, 0.1);
    for (int k = 0; k < 20; ++k) {
      const glm::dvec3 p = centre + 0.1 * glm::normalize(random.InCube());
      const double moved = glm::length(now * p - before * p);
      ASSERT_LE(moved, bound * (1.0 + 1e-12) + 1e-15);
      tightest = std::min(tightest, bound / moved);
    }
  }
  EXPECT_LT(tightest, 1.1);
}

}  // namespace
}  // namespace vps
