#include <cmath>

#include "physics/hinge.hpp"
#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;
using test::Triaxial;

TEST(FreeMotion, StraightDriftOfTenMinutesIsExact) {
  World world;
  // Velocities that are powers of two add without rounding, so any damping, sleeping or lost time shows.
  const int body = test::AddDynamic(&world, {}, BoxMass(2.0, {0.1, 0.2, 0.3}), {{}, {0.125, -0.0625, 0.5}});
  for (int i = 0; i < 600000; ++i) world.Step(kDt);
  const glm::dvec3 p = world.X_WO(body).translation;
  EXPECT_NEAR(p.x, 75.0, 75.0 * 1e-9);
  EXPECT_NEAR(p.y, -37.5, 37.5 * 1e-9);
  EXPECT_NEAR(p.z, 300.0, 300.0 * 1e-9);
  EXPECT_EQ(world.V_WO(body).linear_m_per_s, glm::dvec3(0.125, -0.0625, 0.5));
}

TEST(FreeMotion, SlowDriftNeverFallsAsleep) {
  World world;
  const int body = test::AddDynamic(&world, {}, BoxMass(2.0, {0.1, 0.2, 0.3}), {{}, {0.001, 0, 0}});
  for (int i = 0; i < 10000; ++i) world.Step(kDt);
  EXPECT_NEAR(world.X_WO(body).translation.x, 0.01, 1e-12);
}

// Symplectic Euler: after n steps v = g n dt, x = g dt^2 n (n + 1) / 2. Spin does not change: weight acts at the centre
// of mass, which is not the mesh origin here. The books close over what gravity gave.
TEST(FreeMotion, FallsByTheParabolaWithoutATurnAndTheBooksClose) {
  World::Options options;
  options.gravity_W_m_per_s2 = {0.3, 0.0, -9.81};
  World world(options);
  MassProperties mass = BoxMass(2.0, {0.1, 0.2, 0.3});
  mass.p_OCm_m = {0.05, 0.02, -0.01};
  const int body = test::AddDynamic(&world, {}, mass, {});
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) world.Step(kDt);
  const glm::dvec3 way = options.gravity_W_m_per_s2 * (kDt * kDt * kSteps * (kSteps + 1) / 2);
  EXPECT_NEAR(glm::distance(world.X_WO(body).translation, way), 0.0, 1e-12);
  EXPECT_NEAR(glm::length(world.spin_Nms(body)), 0.0, 1e-15);
  EXPECT_NEAR(world.impulse_balance().linear_magnitude_Ns, 2.0 * glm::length(options.gravity_W_m_per_s2), 1e-9);
  EXPECT_LE(world.impulse_balance().relative(), 1e-12);
}

// The same bits as a load of that size, for a body that a hinge holds: joints do not know where a force comes from.
TEST(FreeMotion, WeightIsALoadToTheJoints) {
  const glm::dvec3 g(0.0, 0.0, -9.81);
  const auto swing = [&](bool by_load) {
    World::Options options;
    if (!by_load) options.gravity_W_m_per_s2 = g;
    World world(options);
    const int body = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.1, 0, 0}}, BoxMass(0.5, {0.1, 0.02, 0.02}), {});
    HingeParams hinge;  // about y, in the origin
    hinge.X_PJ.rotation = core::QuaternionFromRotationVector({std::acos(0.0), 0, 0});
    hinge.X_CJ = {hinge.X_PJ.rotation, {-0.1, 0, 0}};
    EXPECT_TRUE(world.AddMechanism(world.world_body(), body, std::make_unique<Hinge>(hinge)));
    if (by_load) world.SetLoad(body, {0.5 * g, {}});
    for (int i = 0; i < 500; ++i) world.Step(kDt);
    return world.X_WO(body).translation;
  };
  EXPECT_EQ(swing(true), swing(false));
  EXPECT_LT(swing(false).z, -0.05) << "it swings";
}

TEST(FreeMotion, DzhanibekovTumblingKeepsEnergyAndMomentumForAMinute) {
  World world;
  const int body = test::AddDynamic(&world, {}, Triaxial(1, 2, 3), {{0.01, 2.0, 0.01}, {}});
  const double energy = world.kinetic_energy_J(body);
  const glm::dvec3 spin = world.spin_Nms(body);
  double energy_error = 0.0;
  double momentum_error = 0.0;
  int flips = 0;
  double previous = 1.0;
  for (int i = 0; i < 60000; ++i) {
    world.Step(kDt);
    energy_error = std::max(energy_error, std::abs(world.kinetic_energy_J(body) / energy - 1.0));
    momentum_error = std::max(momentum_error, glm::length(world.spin_Nms(body) - spin) / glm::length(spin));
    const double now = glm::dot(world.X_WO(body).rotate({0, 1, 0}), glm::dvec3(0, 1, 0));
    if (now * previous < 0.0) ++flips;
    if (now != 0.0) previous = now;
  }
  RecordProperty("energy_error", std::to_string(energy_error));
  EXPECT_LE(energy_error, 1e-6);
  EXPECT_LE(momentum_error, 1e-10);
  EXPECT_EQ(flips, 5);  // Jacobi elliptic solution: five half turns of the intermediate axis in 60 s
}

// A symmetric top's axis precesses about L at |L| / I_t, closed form.
TEST(FreeMotion, SymmetricTopPrecessesAtItsClosedFormRate) {
  World world;
  const double transverse = 2.0;
  const int body = test::AddDynamic(&world, {}, Triaxial(transverse, transverse, 3.0), {{0.5, 0.0, 4.0}, {}});
  const glm::dvec3 L = world.spin_Nms(body);
  const glm::dvec3 axis0(0, 0, 1);
  constexpr int kSteps = 10000;
  for (int i = 0; i < kSteps; ++i) world.Step(kDt);
  const glm::dvec3 l = glm::normalize(L);
  const glm::dquat precession = core::QuaternionFromRotationVector(l * (glm::length(L) / transverse * kSteps * kDt));
  EXPECT_LT(glm::length(world.X_WO(body).rotate({0, 0, 1}) - precession * axis0), 2e-4);
}

TEST(FreeMotion, BodyTurnsAboutItsCentreOfMassNotItsMeshOrigin) {
  World world;
  MassProperties mass = BoxMass(1.5, {0.1, 0.1, 0.1});
  mass.p_OCm_m = {0.2, 0.0, 0.0};
  // Spin about z with the centre of mass at rest: v_O = -w x p_OCm.
  const int body = test::AddDynamic(&world, {}, mass, {{0, 0, 2.0}, {0, -0.4, 0}});
  for (int i = 0; i < 5000; ++i) world.Step(kDt);
  EXPECT_LT(glm::length(world.center_of_mass_W(body) - glm::dvec3(0.2, 0, 0)), 1e-12);
  EXPECT_NEAR(glm::length(world.X_WO(body).translation - glm::dvec3(0.2, 0, 0)), 0.2, 1e-12);
}

TEST(FreeMotion, InertiaWithProductsIsTurnedToPrincipalAxes) {
  const glm::dquat R = glm::normalize(glm::dquat(0.8, 0.3, -0.4, 0.2));
  const glm::dmat3 M = glm::mat3_cast(R);
  glm::dmat3 diagonal(0.0);
  diagonal[0][0] = 1.0;
  diagonal[1][1] = 2.5;
  diagonal[2][2] = 3.0;
  const glm::dmat3 I = M * diagonal * glm::transpose(M);
  const PrincipalInertia principal = DiagonalizeInertia(I);
  const glm::dmat3 V = glm::mat3_cast(principal.R_OB);
  glm::dmat3 moments(0.0);
  for (int i = 0; i < 3; ++i) moments[i][i] = principal.moments_kg_m2[i];
  const glm::dmat3 back = V * moments * glm::transpose(V);
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(back[c][r], I[c][r], 1e-14);
  }
}

// A force at the mesh origin, beside the centre of mass, accelerates and turns the body, counts in the impulse balance,
// and acts until it is replaced.
TEST(FreeMotion, AWrenchAcceleratesAndTurnsTheBody) {
  World world;
  MassProperties mass = BoxMass(2.0, {0.1, 0.2, 0.3});
  mass.p_OCm_m = {0.1, 0.0, 0.0};
  const int body = test::AddDynamic(&world, {}, mass);
  world.SetLoad(body, {{0.0, 0.5, 0.0}, {0.01, 0.0, 0.0}});
  for (int i = 0; i < 10; ++i) world.Step(kDt);
  EXPECT_NEAR(world.momentum_Ns(body).y, 0.005, 1e-15);
  EXPECT_NEAR(world.spin_Nms(body).x, 1e-4, 1e-12);
  EXPECT_NEAR(world.spin_Nms(body).z, -0.1 * 0.005, 1e-8);
  EXPECT_LT(world.impulse_balance().relative(), 1e-12);
  world.SetLoad(body, {});
  for (int i = 0; i < 10; ++i) world.Step(kDt);
  EXPECT_NEAR(world.momentum_Ns(body).y, 0.005, 1e-15);
}

TEST(FreeMotion, ImpossibleInertiaIsRefusedAtSetup) {
  World world;
  EXPECT_FALSE(world.AddBody({BodyKind::kDynamic, {}, {}, Triaxial(1, 1, 3)}).has_value());
  MassProperties massless = BoxMass(1.0, {1, 1, 1});
  massless.mass_kg = -1.0;
  EXPECT_FALSE(world.AddBody({BodyKind::kDynamic, {}, {}, massless}).has_value());
}

}  // namespace
}  // namespace physics
