#include "vps/multibody/fast_pair_query.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "vps/oracle/closed_form.hpp"
#include "vps/oracle/contact_wrench.hpp"
#include "vps/testing/contact_cases.hpp"

namespace vps {
namespace {

constexpr double kVoxel_m = 1e-3;

// A pair with an accuracy, from pose to pose.
class Engine {
 public:
  Engine(const TriangleMesh& A, const TriangleMesh& B, double voxel_size_m, std::uint32_t num_points)
      : G_(*Cook(A, {voxel_size_m, 0, Method::kFast})),
        S_(*Cook(B, {0.0, num_points, Method::kFast})),
        scratch_(*S_.samples) {
    pair.look_ahead_m = 5e-4;
    pair.accuracy = 0.05;
    scratch_.memory = &memory_;
  }
  const PairResult& Query(const core::Pose& X_AB) {
    QueryFastPair(FastPairOf(S_, G_, memory_), X_AB, X_AB, pair, 0.01, &scratch_, &result_);
    return result_;
  }
  // Of points, for the walk and for what the surface takes.
  void SetBudget(std::uint32_t most_points) { scratch_.most_points = scratch_.walk.most_points = most_points; }
  [[nodiscard]] const TouchIntegral& touch() const { return scratch_.touch; }
  void Forget() { memory_ = {}; }
  [[nodiscard]] std::uint64_t places_read() const { return scratch_.places_read; }
  [[nodiscard]] bool is_cut_short() const { return scratch_.is_cut_short; }
  [[nodiscard]] std::uint32_t samples_tested() const { return scratch_.found.points_tested; }
  PairDescription pair;

 private:
  CookedObject G_, S_;
  FastPairScratch scratch_;
  TouchMemory memory_;
  PairResult result_;
};

// Against vps/oracle: rings that barely touch, with few samples and with many.
TEST(FastPair, ForceIsWithinTwiceItsErrorOfTheExactOne) {
  const TriangleMesh ring = MakeTorus(0.03, 0.012, 32, 16);
  const TriangleMesh box = MakeBox({0.03, 0.02, 0.04});
  const oracle::MeshDistance A(ring);
  const oracle::MeshDistance B(box);
  CaseRandom random(7);
  for (const std::uint32_t num_points : {1024U, 16384U}) {
    Engine engine(ring, box, kVoxel_m, num_points);
    int num_touching = 0;
    for (int i = 0; i < 8; ++i) {
      const core::Pose X_AB{random.Rotation(), 0.045 * random.Direction()};
      const oracle::ContactWrench truth = oracle::IntegrateContactWrench(A, B, X_AB);
      for (int k = 0; k < 3; ++k) engine.Query(X_AB);
      if (!engine.touch().is_contact()) continue;
      ++num_touching;
      const glm::dvec3 off = X_AB.rotate(engine.touch().force_m3) - truth.force_A_m3;
      EXPECT_LE(glm::length(off), 2.0 * engine.touch().error_m3) << num_points;
      EXPECT_LT(glm::length(off), 0.1 * truth.depth_integral_m3) << num_points;
    }
    EXPECT_GE(num_touching, 3);
  }
}

// The peg's axis is shifted by e in a hole wider by the clearance c: the force of FieldWalk.AFewPoints*,
//   F = R L (e (phi_0 + sin(phi_0) cos(phi_0)) - 2 c sin(phi_0)),  cos(phi_0) = c / e.
TEST(FastPair, ForceOfAPegAlongItsHoleIsThatOfTheFormula) {
  const double R = 0.01;
  const double c = 5e-5;
  const double L = 0.03;
  Engine engine(MakeBlockWithHole(0.04, L, R + c, 256), MakeCylinder(R, 0.04, 256), 2.5e-4, 16384);
  for (const double e : {9e-5, 1.2e-4, 2e-4}) {
    const double phi = std::acos(c / e);
    const double force = R * L * (e * (phi + std::sin(phi) * std::cos(phi)) - 2.0 * c * std::sin(phi));
    engine.Query({{1, 0, 0, 0}, {e * std::cos(0.3), e * std::sin(0.3), 0.0}});
    EXPECT_NEAR(glm::length(engine.touch().force_m3) / force, 1.0, engine.pair.accuracy) << e;
  }
}

// A peg along the wall of its hole needs too many patches; its samples are many and agree.
TEST(FastPair, SamplesCountWhereTheyAreSurerThanTheSurface) {
  const ContactCase peg = PegCase(4);
  Engine broad(peg.A, peg.B, peg.voxel_size_m, 65536);
  for (const core::Pose& X : peg.poses) {
    broad.Query(X);
    EXPECT_GT(broad.touch().share_of_samples, 0.9);
    EXPECT_LT(broad.touch().error_m3, broad.pair.accuracy * broad.touch().volume_m3);
  }
  const ContactCase tori = ToriCase(4);
  Engine light(tori.A, tori.B, tori.voxel_size_m, 4096);
  for (const core::Pose& X : tori.poses) {
    light.Query(X);
    EXPECT_LT(light.touch().share_of_samples, 0.1);
  }
}

// A peg pressed into its hole: a tenth is reached with a quarter of the samples that a hundredth takes; either way the
// force is as exact as it is said to be.
TEST(FastPair, TakesAsFewSamplesAsItsAccuracyAsks) {
  const double R = 0.01;
  const double c = 5e-5;
  const double e = 2e-4;
  const double L = 0.03;
  const double phi = std::acos(c / e);
  const double force = R * L * (e * (phi + std::sin(phi) * std::cos(phi)) - 2.0 * c * std::sin(phi));
  Engine engine(MakeBlockWithHole(0.04, L, R + c, 256), MakeCylinder(R, 0.04, 256), 2.5e-4, 65536);
  const core::Pose X_AB{{1, 0, 0, 0}, {e * std::cos(0.3), e * std::sin(0.3), 0.0}};
  std::uint64_t tested[2] = {};
  for (const int i : {0, 1}) {
    engine.pair.accuracy = i == 0 ? 0.1 : 0.01;
    for (int k = 0; k < 8; ++k) engine.Query(X_AB);
    tested[i] = engine.Query(X_AB).counters.points_tested;
    EXPECT_EQ(engine.touch().share_of_samples, 1.0);
    EXPECT_NEAR(glm::length(engine.touch().force_m3), force, engine.touch().error_m3 + 0.001 * force);
    EXPECT_LT(engine.touch().error_m3, engine.pair.accuracy * engine.touch().volume_m3);
  }
  EXPECT_LT(3 * tested[0], tested[1]);
}

// Plates a little apart: coarser samples give the planes. What touches in the next query is as exact as from all of
// them, a face or one corner.
TEST(FastPair, TakesCoarserSamplesWhereNothingTouchesAndFindsWhatDoes) {
  Engine engine(MakeBox({0.1, 0.1, 0.04}), MakeBox({0.06, 0.05, 0.04}), kVoxel_m, 65536);
  engine.pair.negligible_N = 0.0;  // the corner's force could not be felt
  engine.pair.most_places = 200'000;
  const auto above = [](double gap_m) { return core::Pose{{1, 0, 0, 0}, {0.003, 0.001, 0.04 + gap_m}}; };
  engine.Query(above(2e-4));
  const std::uint32_t first = engine.samples_tested();
  for (int k = 0; k < 8; ++k) EXPECT_FALSE(engine.Query(above(2e-4 - 1e-6 * k)).is_in_contact);
  EXPECT_LT(3 * engine.samples_tested(), first);
  EXPECT_TRUE(engine.Query(above(-1e-4)).is_in_contact);
  EXPECT_NEAR(engine.touch().volume_m3, 0.06 * 0.05 * 1e-4, engine.touch().error_m3);

  for (int k = 0; k < 8; ++k) engine.Query(above(2e-4));
  // Turned about its middle: the lowest corner is deeper than the face by the way that its rim has turned.
  const glm::dvec3 turn(2e-2, -2e-2, 0.0);
  const core::Pose tilt{core::QuaternionFromRotationVector(turn), glm::dvec3(0.0)};
  double lowest_m = 0.0;
  for (const glm::dvec3& v : MakeBox({0.06, 0.05, 0.04}).vertices) lowest_m = std::min(lowest_m, tilt.rotate(v).z);
  core::Pose X = tilt;
  X.translation = {0.003, 0.001, 0.02 - lowest_m - 2e-5};
  // Of a corner that three faces meet in, nearly in the plate's normal: a pyramid of depth h over the triangle that its
  // lower face leaves, whose legs are h / 0.02.
  EXPECT_TRUE(engine.Query(X).is_in_contact);
  const double leg_m = 2e-5 / 2e-2;
  EXPECT_NEAR(engine.touch().volume_m3, 2e-5 * leg_m * leg_m / 6.0, 0.2 * 2e-5 * leg_m * leg_m / 6.0);
}

// A ball comes down on a plate by a micrometre a query. While it is apart no place is read for most of the way; it
// touches no later than its force can be felt.
TEST(FastPair, RestsWhileApartAndIsNeverLate) {
  Engine engine(MakeBox({0.1, 0.1, 0.04}), MakeSphere(0.02, 128), kVoxel_m, 4096);
  int num_read = 0;
  double touched_at_m = -1.0;
  for (int i = 0; i < 600; ++i) {
    const double depth_m = -4e-4 + 1e-6 * i;
    const PairResult& result = engine.Query({{1, 0, 0, 0}, {0.0, 0.0, 0.04 - depth_m}});
    if (depth_m < 0.0) {
      EXPECT_FALSE(result.is_in_contact) << depth_m;
      num_read += result.counters.points_tested > 4 * 4096 ? 1 : 0;
    }
    if (result.is_in_contact && touched_at_m < 0.0) touched_at_m = depth_m;
    // Force of the cap by Archimedes, at the modulus k / (rho A).
    const double force_N = engine.pair.stiffness_N_per_m * oracle::SphereOnHalfSpaceForce(0.02, depth_m - 6e-6) /
                           (0.01 * 4.0 * M_PI * 0.02 * 0.02);
    if (depth_m > 6e-6 && force_N > 3.0 * engine.pair.negligible_N) {
      ASSERT_TRUE(result.is_in_contact) << depth_m;
    }
  }
  EXPECT_LT(num_read, 200);
  EXPECT_GT(touched_at_m, 0.0);
}

TEST(FastPair, PlanesKeepTheWrenchWithinOnePercent) {
  for (const ContactCase& c : {BallCase(8), ToriCase(8), PegCase(8)}) {
    Engine engine(c.A, c.B, c.voxel_size_m, 4096);
    const Box box = BoundingBox(c.B);
    int num_touching = 0;
    for (const core::Pose& X_AB : c.poses) {
      const PairResult& result = engine.Query(X_AB);
      if (!result.is_in_contact) continue;
      ++num_touching;
      core::Wrench planes;
      for (const core::ContactPlane& plane : result.planes) {
        const glm::dvec3 n(plane.n_G);
        const glm::dvec3 p_A = X_AB * glm::dvec3(plane.p_S);
        const double gap = glm::dot(n, p_A - glm::dvec3(plane.q_G));
        if (gap >= 0.0) continue;
        const glm::dvec3 force = -gap * static_cast<double>(plane.stiffness_N_per_m) * n;
        planes += core::Wrench{force, glm::cross(p_A - X_AB.translation, force)};
      }
      const double force = glm::length(result.F_So_W.force_N);
      EXPECT_LT(glm::length(planes.force_N - result.F_So_W.force_N), 0.01 * force) << c.name;
      EXPECT_LT(glm::length(planes.torque_Nm - result.F_So_W.torque_Nm),
                0.01 * force * 0.25 * glm::length(box.upper - box.lower))
          << c.name;
    }
    EXPECT_GE(num_touching, 4) << c.name;
  }
}

// A peg leans in its hole, by more than two places let it [Whitney 1982: the angle is clearance over depth]. All of it
// is nearly apart, and no budget is enough to know what its rims add; what its samples see inside is felt, and no more.
TEST(FastPair, FeelsAtLeastWhatItsSamplesSeeInside) {
  constexpr double kRadius_m = 0.01, kClearance_m = 1e-4, kDepth_m = 0.01;
  const TriangleMesh block = MakeBlockWithHole(0.06, kDepth_m, kRadius_m + 0.5 * kClearance_m, 128);
  const TriangleMesh peg = MakeCylinder(kRadius_m, 0.1, 128);
  Engine engine(block, peg, 2.5e-4, 24000);
  const oracle::MeshDistance A(block);
  const oracle::MeshDistance B(peg);
  for (const double over : {1.2, 1.5}) {
    core::Pose X_AB{core::QuaternionFromRotationVector({over * kClearance_m / kDepth_m, 0.0, 0.0}), {}};
    X_AB.translation = X_AB.rotate({0.0, 0.0, 0.05 - 0.5 * kDepth_m});
    EXPECT_TRUE(engine.Query(X_AB).is_in_contact);
    EXPECT_TRUE(engine.is_cut_short());
    const oracle::ContactWrench truth = oracle::IntegrateContactWrench(A, B, X_AB, {.relative = 0.01});
    const TouchIntegral& touch = engine.touch();
    EXPECT_GT(touch.volume_m3, 0.5 * truth.depth_integral_m3) << over;
    EXPECT_LT(touch.volume_m3, 1.05 * truth.depth_integral_m3) << over;
    EXPECT_GT(touch.error_m3, std::abs(touch.volume_m3 - truth.depth_integral_m3)) << over;
  }
}

// A peg along the wall of its hole: what so small a budget says of the surface does not count beside the samples. It is
// left unread, but for every now and then, with the result of a query that reads it.
TEST(FastPair, LeavesASurfaceUnreadThatDidNotCount) {
  const ContactCase peg = PegCase(1);
  Engine engine(peg.A, peg.B, peg.voxel_size_m, 16384);
  Engine forgetful(peg.A, peg.B, peg.voxel_size_m, 16384);
  for (Engine* one : {&engine, &forgetful}) {
    one->pair.accuracy = 0.01;
    one->pair.most_places = 256;
  }
  constexpr int kCount = 100;
  int num_read = 0;
  for (int i = 0; i < kCount; ++i) {
    core::Pose X_AB = peg.poses[0];
    X_AB.translation.x += 1e-7 * i;
    forgetful.Forget();
    const PairResult& expected = forgetful.Query(X_AB);
    const PairResult& result = engine.Query(X_AB);
    ASSERT_GT(forgetful.places_read(), 0U);
    ASSERT_EQ(forgetful.touch().share_of_samples, 1.0);
    EXPECT_EQ(result.F_So_W.force_N, expected.F_So_W.force_N) << i;
    EXPECT_EQ(result.F_So_W.torque_Nm, expected.F_So_W.torque_Nm) << i;
    EXPECT_EQ(result.force_error_N, expected.force_error_N) << i;
    EXPECT_EQ(result.signed_distance_m, expected.signed_distance_m) << i;
    EXPECT_TRUE(engine.is_cut_short()) << i;
    num_read += engine.places_read() > 0 ? 1 : 0;
  }
  EXPECT_GE(num_read, kCount / 25);
  EXPECT_LE(num_read, kCount / 15);
}

// What a budget has left out of the walk is not known, and counts as an error.
TEST(FastPair, ErrorCountsWhatABudgetLeftOut) {
  const double R = 0.01;
  const double c = 5e-5;
  const double L = 0.03;
  const double e = 2e-4;
  const double phi = std::acos(c / e);
  const double force = R * L * (e * (phi + std::sin(phi) * std::cos(phi)) - 2.0 * c * std::sin(phi));
  Engine engine(MakeBlockWithHole(0.04, L, R + c, 256), MakeCylinder(R, 0.04, 256), 2.5e-4, 16384);
  for (const std::uint32_t budget : {1200U, 2400U, 4800U}) {
    engine.SetBudget(budget);
    const PairResult& result = engine.Query({{1, 0, 0, 0}, {e, 0.0, 0.0}});
    EXPECT_TRUE(engine.is_cut_short()) << budget;
    EXPECT_TRUE(result.is_in_contact) << budget;
    EXPECT_LE(glm::length(engine.touch().force_m3 - glm::dvec3(-force, 0.0, 0.0)), 2.0 * engine.touch().error_m3)
        << budget << ' ' << engine.touch().force_m3.x / force << ' ' << engine.touch().error_m3 / force;
  }
}

// With more accuracy more places are read, with a budget no more than that many, and the result says so.
TEST(FastPair, ReadsMoreForMoreAccuracyAndNoMoreThanItsBudget) {
  const TriangleMesh torus = MakeTorus(0.03, 0.012, 64, 32);
  const core::Pose X{core::QuaternionFromRotationVector({0.7, 0.2, 0.1}), {0.07, 0.01, 0.002}};
  std::uint64_t before = 0;
  for (const double accuracy : {0.1, 0.02, 0.01}) {
    Engine engine(torus, torus, kVoxel_m, 1024);
    engine.pair.accuracy = accuracy;
    engine.pair.most_places = 100'000;
    for (int i = 0; i < 4; ++i) engine.Query(X);
    EXPECT_GT(engine.Query(X).counters.points_tested, before);
    before = engine.Query(X).counters.points_tested;
  }
  Engine engine(torus, torus, kVoxel_m, 4096);
  engine.pair.accuracy = 0.001;
  engine.pair.most_places = 512;
  const PairResult& result = engine.Query(X);
  EXPECT_LE(result.counters.points_tested, 4096U + 512U * kPointsOfPlace);
  EXPECT_TRUE(engine.is_cut_short());
  EXPECT_GT(result.force_error_N, 0.001 * glm::length(result.F_So_W.force_N));
}

}  // namespace
}  // namespace vps
