// The world against the closed forms of testing/closed_form/.
#include "physics/testing/trials/reference.hpp"

#include <cmath>
#include <vector>

#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"
#include "physics/testing/closed_form/contact_laws.hpp"
#include "physics/testing/closed_form/free_rotation.hpp"
#include "physics/testing/closed_form/impact.hpp"
#include "physics/testing/closed_form/snap_work.hpp"
#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/heavy_on_light.hpp"

namespace physics {
namespace {

using test::kDt;
using test::Triaxial;

TEST(Reference, DriftOfTenMinutesAtAnySpeedIsExact) {
  const double worst = trials::DriftError();
  RecordProperty("relative_error", std::to_string(worst * 1e15) + "e-15");
  EXPECT_LE(worst, 1e-10);
}

TEST(Reference, TumblingFlipsAtTheTimesOfTheEllipticFunctions) {
  World world;
  const glm::dvec3 moments(1, 2, 3);
  const glm::dvec3 w(0.01, 2.0, 0.01);
  const int body = test::AddDynamic(&world, {}, Triaxial(1, 2, 3), {w, {}});
  const closed_form::FreeRotation exact(moments, w);
  int flips = 0;
  double worst_s = 0.0;
  double previous = w.y;
  for (int i = 1; i <= 60000; ++i) {
    world.Step(kDt);
    const core::Pose X_WB = world.X_WO(body);
    const double now = (glm::conjugate(X_WB.rotation) * world.V_WO(body).angular_rad_per_s).y;
    if (now * previous < 0.0) {
      const double measured_s = (i - now / (now - previous)) * kDt;
      worst_s = std::max(worst_s, std::abs(measured_s - exact.flip_s(flips)));
      ++flips;
    }
    previous = now;
  }
  RecordProperty("worst_flip_us", std::to_string(worst_s * 1e6));
  EXPECT_EQ(flips, 5);
  EXPECT_LE(worst_s, 1e-3);
}

TEST(Reference, StiffPlaneImpactEqualsNewtonsLawWithoutRestitution) {
  World world;
  const MassProperties mass_a = BoxMass(1.0, {0.1, 0.12, 0.08});
  const MassProperties mass_b = BoxMass(0.3, {0.1, 0.07, 0.1});
  const core::Twist V_a{{}, {0.4, 0.02, 0}};
  const core::Twist V_b{{}, {-0.1, 0.0, 0.05}};
  const int a = test::AddDynamic(&world, {{1, 0, 0, 0}, {-0.05, 0.01, 0}}, mass_a, V_a);
  const int b = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.05, 0, 0}}, mass_b, V_b);
  const int pair = world.AddContactPair(a, b).value();
  core::ContactSet set;
  test::AddPlane(&set, 1, {0.05, 0.02, 0.01}, {-0.05, 0, 0}, {-1, 0, 0}, 1e12);  // touching now
  world.SetContactPlanes(pair, set);
  world.Step(kDt);
  closed_form::ImpactBody exact_a{1.0, glm::inverse(mass_a.I_Cm_O_kg_m2), {}, V_a.linear_m_per_s, {}};
  exact_a.p_CmC_W = glm::dvec3(glm::vec3(0.05, 0.02, 0.01));  // as on the wire
  closed_form::ImpactBody exact_b{1.0 / 0.3, glm::inverse(mass_b.I_Cm_O_kg_m2), {}, V_b.linear_m_per_s, {}};
  exact_b.p_CmC_W = exact_a.p_CmC_W + glm::dvec3(-0.05, 0.01, 0) - glm::dvec3(0.05, 0, 0);
  closed_form::Impact(&exact_a, &exact_b, {-1, 0, 0}, 0.0);
  EXPECT_LT(glm::length(world.momentum_Ns(a) - exact_a.v_Cm_W), 2e-6);  // the gap is zero to the float's 1e-9 m
  EXPECT_LT(glm::length(world.momentum_Ns(b) / 0.3 - exact_b.v_Cm_W), 1e-5);
  EXPECT_LT(glm::length(world.spin_Nms(b) - mass_b.I_Cm_O_kg_m2 * exact_b.w_W), 1e-7);
}

TEST(Reference, MomentumIsConservedThroughAMinuteOfImpactsAndJoints) {
  const trials::MomentumResidual residual = trials::MixedContacts(60.0);
  EXPECT_GT(residual.num_pushes, 100);
  RecordProperty("linear_e15", std::to_string(residual.linear * 1e15));
  RecordProperty("angular_e15", std::to_string(residual.angular * 1e15));
  EXPECT_LE(residual.linear, 1e-9);
  EXPECT_LE(residual.angular, 1e-9);
  for (const ImpulseBalance& part : {residual.joints, residual.contacts}) {
    EXPECT_GT(part.linear_magnitude_Ns, 0.1);
    EXPECT_LE(part.relative(), 1e-9);
    EXPECT_LE(part.relative_angular(), 1e-9);
  }
  RecordProperty("joints_e15", std::to_string(residual.joints.relative() * 1e15));
  RecordProperty("contacts_e15", std::to_string(residual.contacts.relative() * 1e15));
}

void ExpectCoulombsLaw(ContactKind kind) {
  constexpr double kFriction = 0.3;  // 16.70 degrees
  const double creep = trials::BlockOnSlope(0.95 * kFriction, kFriction, kind).creep_m_per_s;
  testing::Test::RecordProperty("creep_nm_per_s", std::to_string(creep * 1e9));
  EXPECT_LT(creep, 1e-6);
  const double a = trials::BlockOnSlope(1.1 * kFriction, kFriction, kind).acceleration_m_per_s2;
  const double exact = closed_form::SlopeAcceleration_m_per_s2(std::atan(1.1 * kFriction), kFriction, trials::kGravity);
  testing::Test::RecordProperty("acceleration_ratio", std::to_string(a / exact));
  EXPECT_NEAR(a / exact, 1.0, 0.02);
}

TEST(Reference, BlockSticksBelowTheAngleOfFrictionAndSlidesByCoulombAbove) {
  ExpectCoulombsLaw(ContactKind::kCompliant);
}

TEST(Reference, BlockOnHardContactSticksAndSlidesByCoulomb) {
  ExpectCoulombsLaw(ContactKind::kHard);
}

// A part on a snap, moved by a kinematic hand through a spring far stiffer than the snap, so that the hand's force
// equals the snap's. (Where the snap's force jumps by dF, the hand's spring k loses dF^2 / 2k: 0.04 % of a cycle here.)
struct SlowSnap {
  World world;
  SnapParams params;
  int part = -1, hand = -1;
  SpringCoupling* spring = nullptr;
  Snap* snap = nullptr;
  double z = 0.006;
  double work_J = 0.0;
  double peak_in_N = 0.0;
  double peak_out_N = 0.0;

  explicit SlowSnap(double damping) {
    params.engage_force_N = 15.0;
    params.release_force_N = 20.0;
    params.damping_N_s_per_m = damping;
    const core::Pose X{{1, 0, 0, 0}, {0, 0, z}};
    part = test::AddDynamic(&world, X, BoxMass(0.3, {0.03, 0.03, 0.1}));
    hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, X, {}, {}});
    snap = trials::AddMechanism<Snap>(&world, world.world_body(), part, params);
    spring = trials::AddMechanism<SpringCoupling>(&world, hand, part, SpringCouplingParams{1e8, 500.0, 40, 0.6});
    spring->Attach(X, X, X.translation);
  }
  void Move(double to_z, double speed) {
    const double direction = to_z > z ? 1.0 : -1.0;
    const int steps = static_cast<int>(std::lround(std::abs(to_z - z) / (speed * kDt)));
    for (int i = 0; i < steps; ++i) {
      z += direction * speed * kDt;
      world.SetKinematic(hand, {{1, 0, 0, 0}, {0, 0, z}}, {{}, {0, 0, direction * speed}});
      world.Step(kDt);
      const double on_part_N = -spring->F_Po_W().force_N.z;
      work_J += on_part_N * direction * speed * kDt;
      if (direction < 0.0 && snap->state() == 0) peak_in_N = std::max(peak_in_N, -on_part_N);
      if (direction > 0.0 && snap->state() == 1) peak_out_N = std::max(peak_out_N, on_part_N);
    }
  }
};

TEST(Reference, SnapPeaksAndLoopWorkEqualThoseOfItsProfile) {
  SlowSnap scene(2.0);
  scene.Move(-0.0005, 0.0005);  // slow: the error of the 1 ms step is proportional to the speed
  scene.Move(0.006, 0.0005);
  EXPECT_NEAR(scene.peak_in_N, 15.0, 0.15);
  EXPECT_NEAR(scene.peak_out_N, 20.0, 0.2);
  const double exact = closed_form::SnapCycleWork_J(scene.params);
  RecordProperty("work_ratio", std::to_string(scene.work_J / exact));
  EXPECT_NEAR(scene.work_J / exact, 1.0, 0.01);
}

TEST(Reference, SnapGainsNoEnergyInAThousandCycles) {
  // Fast cycles without damping in the snap: each must dissipate at least the loop work of the profile.
  SlowSnap scene(0.0);
  const double exact = closed_form::SnapCycleWork_J(scene.params);
  double least = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const double before = scene.work_J;
    scene.Move(-0.0006, 0.2);
    scene.Move(0.006, 0.2);
    least = std::min(least, scene.work_J - before);
  }
  RecordProperty("least_ratio", std::to_string(least / exact));
  EXPECT_GT(least, 0.0);
}

void ExpectHeavyOnLightRests(double ratio, ContactKind kind) {
  trials::HeavyOnLight stack(ratio, kind);
  for (int i = 0; i < 1000; ++i) stack.Step();
  testing::Test::RecordProperty("deepest_um_" + std::to_string(static_cast<int>(ratio)),
                                std::to_string(stack.deepest_m() * 1e6));
  EXPECT_GT(stack.world().num_direct_solves(), 900u) << "once it is needed it comes first";
  EXPECT_LT(stack.world().solver_work().num_sweeps, 2000u);
  EXPECT_EQ(stack.world().num_fallbacks(), 0u);
  EXPECT_LE(stack.deepest_m(), 50e-6) << ratio;
  EXPECT_NEAR(stack.ForceRatio(), 1.0, 1e-3) << ratio;
}

TEST(Reference, HeavyOnLightRestsWithinFiftyMicrometres) {
  for (const double ratio : {1000.0, 5000.0}) ExpectHeavyOnLightRests(ratio, ContactKind::kCompliant);
}

TEST(Reference, HeavyOnLightRestsOnHardContact) {
  for (const double ratio : {1000.0, 5000.0}) ExpectHeavyOnLightRests(ratio, ContactKind::kHard);
}

TEST(Reference, FiftyDistantPartsAddNoWorkToTheSolver) {
  const SolverWork alone = trials::WorkOfAMover(0);
  const SolverWork among = trials::WorkOfAMover(50);
  EXPECT_GT(alone.num_rows, 0u);
  EXPECT_EQ(among.num_islands, alone.num_islands);
  EXPECT_EQ(among.num_rows, alone.num_rows);
  EXPECT_EQ(among.num_sweeps, alone.num_sweeps);
  EXPECT_EQ(among.num_row_updates, alone.num_row_updates);
  EXPECT_EQ(among.num_direct_solves, alone.num_direct_solves);
}

}  // namespace
}  // namespace physics
