#include "vps/walk/walk_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {
namespace {

double Signed(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}
glm::dvec3 Vector(std::mt19937_64& random) {
  return {Signed(random), Signed(random), Signed(random)};
}

struct Couple {
  DistanceField field;
  SampleTree points;
  core::Pose start;  // touching a little
};
const Couple& Peg() {
  static const Couple couple{*BuildField(MakeBlockWithHole(0.04, 0.03, 0.0105, 64), 0.0005),
                             BuildSampleTree(*SampleSurface(MakeCylinder(0.01, 0.04, 64), 5000)),
                             {{1.0, 0.0, 0.0, 0.0}, {0.0006, 0.0, 0.0}}};
  return couple;
}
const Couple& Tori() {
  static const Couple couple{*BuildField(MakeTorus(0.05, 0.02, 48, 24), 0.001),
                             BuildSampleTree(*SampleSurface(MakeTorus(0.05, 0.02, 48, 24), 20000)),
                             {{1.0, 0.0, 0.0, 0.0}, {0.1395, 0.0, 0.0}}};
  return couple;
}

// Walks with a memory beside walks without.
class Beside {
 public:
  Beside(const Couple& couple, double margin_m) : couple_(couple), margin_m_(margin_m) { with_.memory = &memory_; }

  void ExpectTheSame(const core::Pose& X_GS) {
    const FieldWalkResult anew = WalkField(couple_.points, couple_.field, X_GS, margin_m_, &without_);
    const FieldWalkResult result = WalkField(couple_.points, couple_.field, X_GS, margin_m_, &with_);
    ASSERT_EQ(result.force_m3, anew.force_m3);
    ASSERT_EQ(result.moment_m4, anew.moment_m4);
    ASSERT_EQ(result.volume_m3, anew.volume_m3);
    ASSERT_EQ(result.square_m4, anew.square_m4);
    ASSERT_EQ(result.deepest_m, anew.deepest_m);
    ASSERT_EQ(result.deepest_point, anew.deepest_point);
    ASSERT_EQ(result.num_near, anew.num_near);
    ASSERT_EQ(result.num_near_blocks, anew.num_near_blocks);
    for (std::uint32_t i = 0; i < anew.num_near_blocks; ++i) {
      ASSERT_EQ(with_.near_blocks[i], without_.near_blocks[i]);
      for (std::uint32_t k = 0; k < kBlock; ++k) ASSERT_EQ(with_.depths(i)[k], without_.depths(i)[k]);
    }
    ++num_walks;
    num_touching += anew.num_colliding > 0 ? 1 : 0;
    num_remembered += result.spheres_tested == 0 ? 1 : 0;
  }

  int num_walks = 0;
  int num_touching = 0;
  int num_remembered = 0;  // without the tree

 private:
  const Couple& couple_;
  double margin_m_;
  FieldWalkScratch with_{couple_.points};
  FieldWalkScratch without_{couple_.points};
  FieldWalkMemory memory_;
};

core::Pose Moved(const core::Pose& X, const glm::dvec3& shift_m, const glm::dvec3& turn) {
  return {glm::normalize(core::QuaternionFromRotationVector(turn) * X.rotation), X.translation + shift_m};
}

TEST(WalkMemory, GivesTheSameSumsBitForBitOverSmoothMotions) {
  for (const Couple* couple : {&Peg(), &Tori()}) {
    const double s = couple->field.voxel_size_m;
    for (const double margin_m : {0.0, 0.002}) {
      Beside beside(*couple, margin_m);
      std::mt19937_64 random(3);
      for (const double step : {0.003, 0.02, 0.08, 0.3}) {
        core::Pose X = couple->start;
        glm::dvec3 shift(0.0);
        glm::dvec3 turn(0.0);
        for (int i = 0; i < 250; ++i) {
          shift = 0.95 * shift + 0.2 * Vector(random);
          turn = 0.95 * turn + 0.2 * Vector(random);
          X = Moved(X, step * s * shift, step * s / couple->points.radius_m * turn);
          // Back towards the start, or it would wander off.
          X.translation += 0.01 * step * (couple->start.translation - X.translation);
          beside.ExpectTheSame(X);
          if (testing::Test::HasFatalFailure()) return;
        }
      }
      EXPECT_GT(beside.num_touching, 100);
      EXPECT_GT(beside.num_remembered, margin_m == 0.0 ? beside.num_walks / 4 : 0);
    }
  }
}

// Creeps in one direction by far less than the skin each cycle; swings at about the skin's size; stands still and
// jumps; turns about a place far away.
TEST(WalkMemory, GivesTheSameSumsBitForBitOverAdversarialMotions) {
  const Couple& couple = Tori();
  const double s = couple.field.voxel_size_m;
  Beside beside(couple, 0.0);
  const auto run = [&](int cycles, const auto& pose_of) {
    for (int i = 0; i < cycles && !testing::Test::HasFatalFailure(); ++i) beside.ExpectTheSame(pose_of(i));
  };
  const core::Pose apart = Moved(couple.start, {0.0015, 0.0, 0.0}, {});
  run(600, [&](int i) { return Moved(apart, {-0.005 * s * i, 0.0, 0.0}, {}); });
  for (const double size : {0.1, 0.124, 0.126, 0.4, 0.51, 1.0}) {
    run(60, [&](int i) { return Moved(apart, {(i % 2 == 0 ? 0.0 : -size * s) - 0.02 * s * i, 0.0, 0.0}, {}); });
  }
  run(200, [&](int i) { return i % 20 < 19 ? apart : Moved(couple.start, {-1e-5 * i, 0.0, 0.0}, {}); });
  run(200, [&](int i) {
    const glm::dquat turn = core::QuaternionFromRotationVector({0.0, 0.0, 2e-5 * i * i});
    const glm::dvec3 axis(0.14, 0.3, 0.0);
    return core::Pose{turn, axis + turn * (couple.start.translation - axis)};
  });
  std::mt19937_64 random(8);
  core::Pose X = couple.start;
  run(400, [&](int i) {
    const double size = s * std::pow(10.0, -2.0 + 0.25 * (i % 9));
    X = Moved(couple.start, size * Vector(random), size / couple.points.radius_m * Vector(random));
    return X;
  });
  EXPECT_GT(beside.num_touching, 200);
  EXPECT_GT(beside.num_remembered, 300);
}

TEST(WalkMemory, FreeDistanceIsFree) {
  const Couple& couple = Tori();
  FieldWalkMemory memory;
  FieldWalkScratch scratch(couple.points);
  scratch.memory = &memory;
  std::mt19937_64 random(5);
  core::Pose X = Moved(couple.start, {0.012, 0.0, 0.0}, {});
  int num_free = 0;
  for (int i = 0; i < 2000; ++i) {
    X = Moved(X, glm::dvec3(-4e-6, 0.0, 0.0) + 4e-5 * Vector(random), 4e-4 * Vector(random));
    const FieldWalkResult result = WalkField(couple.points, couple.field, X, 0.001, &scratch);
    if (result.num_near > 0) break;
    if (!(result.free_distance_m > 0.0)) continue;
    ++num_free;
    if (i % 20 != 0) continue;
    const core::Pose moved = Moved(X, 0.9999 * result.free_distance_m * glm::normalize(Vector(random)), {});
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
  const Couple& couple = Tori();
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
  std::mt19937_64 random(6);
  double tightest = 1e30;
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10.0, -5.0 + (i % 6));
    const core::Pose before = Moved({}, Vector(random), 3.0 * Vector(random));
    const core::Pose now = Moved(before, size * (i % 3 == 0 ? 0.0 : 1.0) * Vector(random), size * Vector(random));
    const glm::dvec3 centre = 0.2 * Vector(random);
    const double bound = MotionBound(before, now, centre, 0.1);
    for (int k = 0; k < 20; ++k) {
      const glm::dvec3 p = centre + 0.1 * glm::normalize(Vector(random));
      const double moved = glm::length(now * p - before * p);
      ASSERT_LE(moved, bound * (1.0 + 1e-12) + 1e-15);
      tightest = std::min(tightest, bound / moved);
    }
  }
  EXPECT_LT(tightest, 1.1);
}

}  // namespace
}  // namespace vps
