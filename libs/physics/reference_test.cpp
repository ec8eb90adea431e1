// The world against the exact answers of closed_form/.
#include <cmath>
#include <vector>

#include "physics/closed_form/contact_laws.hpp"
#include "physics/closed_form/free_rotation.hpp"
#include "physics/closed_form/impact.hpp"
#include "physics/closed_form/snap_work.hpp"
#include "physics/snap.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/test_support.hpp"

namespace physics {
namespace {

using test::kDt;

constexpr double kGravity = 9.81;  // a test load; scenes are without

MassProperties Triaxial(double a, double b, double c) {
  MassProperties m;
  m.I_Cm_O_kg_m2 = glm::dmat3(0.0);
  m.I_Cm_O_kg_m2[0][0] = a;
  m.I_Cm_O_kg_m2[1][1] = b;
  m.I_Cm_O_kg_m2[2][2] = c;
  return m;
}

glm::dvec3 TotalMomentum(const World& world, const std::vector<int>& bodies) {
  glm::dvec3 p(0.0);
  for (const int body : bodies) p += world.momentum_Ns(body);
  return p;
}
glm::dvec3 TotalAngularMomentum(const World& world, const std::vector<int>& bodies) {
  glm::dvec3 L(0.0);
  for (const int body : bodies) {
    L += world.spin_Nms(body) + glm::cross(world.center_of_mass_W(body), world.momentum_Ns(body));
  }
  return L;
}

TEST(Reference, DriftOfTenMinutesAtAnySpeedIsExact) {
  World world;
  const glm::dvec3 start(0.1, -0.7, 3.0);
  const glm::dvec3 v(0.1, -0.0317, 0.77777);
  const int body = test::AddDynamic(&world, {{1, 0, 0, 0}, start}, BoxMass(2.0, {0.1, 0.2, 0.3}), {{}, v});
  double worst = 0.0;
  for (int i = 1; i <= 600000; ++i) {
    world.Step(kDt);
    if (i % 1000 != 0) continue;
    const double t = i * kDt;
    const glm::dvec3 exact = closed_form::DriftPosition(start, v, t);
    worst = std::max(worst, glm::length(world.center_of_mass_W(body) - exact) / glm::length(v * t));
  }
  RecordProperty("relative_error", std::to_string(worst * 1e15) + "e-15");
  EXPECT_LE(worst, 1e-10);
}

TEST(Reference, TumblingFlipsWhenTheEllipticFunctionsDo) {
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

TEST(Reference, StiffPlaneMakesTheImpactOfNewtonsLawWithoutRestitution) {
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

// Blocks on a spring chain that knock together: contacts with friction and joints for 60 s in free space.
TEST(Reference, MomentumIsKeptThroughAMinuteOfImpactsAndJoints) {
  World world;
  std::vector<int> bodies;
  std::vector<int> pairs;
  for (int i = 0; i < 4; ++i) {
    bodies.push_back(test::AddDynamic(&world, {{1, 0, 0, 0}, {0.11 * i, 0.003 * i, 0}},
                                      BoxMass(0.3 + 0.8 * i, {0.1, 0.08, 0.12}),
                                      {{0.02 * i, -0.03, 0.01}, {0.2 - 0.15 * i, 0.01 * i, -0.01}}));
  }
  for (std::size_t i = 0; i + 1 < bodies.size(); ++i) {
    auto* spring =
        test::MustAddMechanism<SpringCoupling>(&world, bodies[i], bodies[i + 1], SpringCouplingParams{40, 0, 0.5, 0});
    const core::Pose X_P = world.X_WO(bodies[i]);
    const core::Pose X_C = world.X_WO(bodies[i + 1]);
    spring->Attach(X_P, X_C, 0.5 * (X_P.translation + X_C.translation));
    pairs.push_back(world.AddContactPair(bodies[i], bodies[i + 1]).value());
    core::ContactSet set;
    set.friction = 0.3f;
    std::uint32_t id = 0;
    for (const double y : {-0.03, 0.03}) {
      for (const double z : {-0.05, 0.05}) test::AddPlane(&set, ++id, {0.05, y, z}, {-0.05, 0, 0}, {-1, 0, 0}, 2e4);
    }
    world.SetContactPlanes(pairs.back(), set);
  }
  const glm::dvec3 p = TotalMomentum(world, bodies);
  const glm::dvec3 L = TotalAngularMomentum(world, bodies);
  int pushes = 0;
  for (int i = 0; i < 60000; ++i) {
    world.Step(kDt);
    for (const int pair : pairs) pushes += world.contact(pair).num_pushing > 0 ? 1 : 0;
  }
  EXPECT_GT(pushes, 100);
  const ImpulseBalance balance = world.impulse_balance();
  const double linear = glm::length(TotalMomentum(world, bodies) - p) / balance.linear_magnitude_Ns;
  const double angular = glm::length(TotalAngularMomentum(world, bodies) - L) / balance.angular_magnitude_Nms;
  RecordProperty("linear_e15", std::to_string(linear * 1e15));
  RecordProperty("angular_e15", std::to_string(angular * 1e15));
  EXPECT_LE(linear, 1e-9);
  EXPECT_LE(angular, 1e-9);
  for (const ImpulseBalance& part : {world.joint_balance(), world.contact_balance()}) {
    EXPECT_GT(part.linear_magnitude_Ns, 0.1);
    EXPECT_LE(part.relative(), 1e-9);
    EXPECT_LE(part.relative_angular(), 1e-9);
  }
  RecordProperty("joints_e15", std::to_string(world.joint_balance().relative() * 1e15));
  RecordProperty("contacts_e15", std::to_string(world.contact_balance().relative() * 1e15));
}

// A block on four feet on the plane z = 0, under gravity turned by the slope's angle: down the slope is +x.
struct Slope {
  static constexpr double kMass = 1.0;
  World world;
  int block, pair, load;

  Slope(double tangent, double friction, ContactKind kind) {
    block = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.02}}, BoxMass(kMass, {0.1, 0.1, 0.04}));
    pair = world.AddContactPair(block, world.world_body(), kind).value();
    load = world.AddContactPair(block, world.world_body()).value();
    core::ContactSet set;
    set.friction = static_cast<float>(friction);
    set.damping_N_s_per_m = 50.0f;
    std::uint32_t id = 0;
    for (const double x : {-0.05, 0.05}) {
      for (const double y : {-0.05, 0.05}) test::AddPlane(&set, ++id, {x, y, -0.02}, {0, 0, 0}, {0, 0, 1}, 2.5e4);
    }
    world.SetContactPlanes(pair, set);
    const double angle = std::atan(tangent);
    world.SetContactWrench(load, {kMass * kGravity * glm::dvec3(std::sin(angle), 0, -std::cos(angle)), {}});
  }
  void Run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kDt)); ++i) world.Step(kDt);
  }
  [[nodiscard]] double x() const { return world.center_of_mass_W(block).x; }
};

void ExpectCoulombsLaw(ContactKind kind) {
  constexpr double kFriction = 0.3;  // 16.70 degrees
  Slope sticks(0.95 * kFriction, kFriction, kind);
  sticks.Run(2.0);
  const double before = sticks.x();
  sticks.Run(10.0);
  const double creep = std::abs(sticks.x() - before) / 10.0;
  testing::Test::RecordProperty("creep_nm_per_s", std::to_string(creep * 1e9));
  EXPECT_LT(creep, 1e-6);

  Slope slides(1.1 * kFriction, kFriction, kind);
  slides.Run(1.0);
  const double v0 = slides.world.momentum_Ns(slides.block).x / Slope::kMass;
  slides.Run(1.0);
  const double a = slides.world.momentum_Ns(slides.block).x / Slope::kMass - v0;
  const double exact = closed_form::SlopeAcceleration_m_per_s2(std::atan(1.1 * kFriction), kFriction, kGravity);
  testing::Test::RecordProperty("acceleration_ratio", std::to_string(a / exact));
  EXPECT_NEAR(a / exact, 1.0, 0.02);
}

TEST(Reference, BlockSticksBelowTheAngleOfFrictionAndSlidesByCoulombAbove) {
  ExpectCoulombsLaw(ContactKind::kCompliant);
}

TEST(Reference, BlockOnHardContactSticksAndSlidesToo) {
  ExpectCoulombsLaw(ContactKind::kHard);
}

// A part on a snap, moved by a kinematic hand through a spring far stiffer than the snap's slopes: the hand's force is
// the snap's. (Where the snap's force jumps by dF the hand's spring k loses dF^2 / 2k: 0.04 % of a cycle here.)
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
    snap = test::MustAddMechanism<Snap>(&world, world.world_body(), part, params);
    spring = test::MustAddMechanism<SpringCoupling>(&world, hand, part, SpringCouplingParams{1e8, 500.0, 40, 0.6});
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

TEST(Reference, SnapPeaksAndLoopWorkAreThoseOfItsFile) {
  SlowSnap scene(2.0);
  scene.Move(-0.0005, 0.0005);  // slow: what is lost to the step of 1 ms goes with the speed
  scene.Move(0.006, 0.0005);
  EXPECT_NEAR(scene.peak_in_N, 15.0, 0.15);
  EXPECT_NEAR(scene.peak_out_N, 20.0, 0.2);
  const double exact = closed_form::SnapCycleWork_J(scene.params);
  RecordProperty("work_ratio", std::to_string(scene.work_J / exact));
  EXPECT_NEAR(scene.work_J / exact, 1.0, 0.01);
}

TEST(Reference, SnapGivesNoEnergyInAThousandCycles) {
  // Fast cycles without any damping in the snap: each must take at least what the profile alone takes.
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

// A heavy block on a light one on the ground, each on four corners, with their weight from the first step on.
void ExpectHeavyOnLightRests(double ratio, ContactKind kind) {
  World world;
  const double light_kg = 0.2;
  const int light = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.05}}, BoxMass(light_kg, {0.1, 0.1, 0.1}));
  const int heavy = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.15}}, BoxMass(ratio * light_kg, {0.1, 0.1, 0.1}));
  const int lower = world.AddContactPair(light, world.world_body(), kind).value();
  const int upper = world.AddContactPair(heavy, light, kind).value();
  core::ContactSet set;
  set.friction = 0.3f;
  std::uint32_t id = 0;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) test::AddPlane(&set, ++id, {x, y, -0.05}, {x, y, 0}, {0, 0, 1}, 1e12);
  }
  world.SetContactPlanes(lower, set);
  for (auto& plane : set.planes) plane.q_G.z = 0.05f;
  world.SetContactPlanes(upper, set);
  const int load = world.AddContactPair(heavy, world.world_body()).value();
  const int weight = world.AddContactPair(light, world.world_body()).value();
  world.SetContactWrench(load, {{0, 0, -kGravity * ratio * light_kg}, {}});
  world.SetContactWrench(weight, {{0, 0, -kGravity * light_kg}, {}});
  double deepest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    world.Step(kDt);
    deepest = std::max({deepest, -world.SmallestGap_m(lower), -world.SmallestGap_m(upper)});
  }
  testing::Test::RecordProperty("deepest_um_" + std::to_string(static_cast<int>(ratio)), std::to_string(deepest * 1e6));
  EXPECT_GT(world.num_direct_solves(), 900u) << "once it is needed it comes first";
  EXPECT_LT(world.solver_work().num_sweeps, 2000u);
  EXPECT_EQ(world.num_fallbacks(), 0u);
  EXPECT_LE(deepest, 50e-6) << ratio;
  EXPECT_NEAR(world.contact(lower).F_So_W.force_N.z / (kGravity * light_kg * (1.0 + ratio)), 1.0, 1e-3) << ratio;
}

TEST(Reference, HeavyOnLightRestsWithinFiftyMicrometres) {
  for (const double ratio : {1000.0, 5000.0}) ExpectHeavyOnLightRests(ratio, ContactKind::kCompliant);
}

TEST(Reference, HeavyOnLightRestsOnHardContact) {
  for (const double ratio : {1000.0, 5000.0}) ExpectHeavyOnLightRests(ratio, ContactKind::kHard);
}

// A box that bounces on the floor, and parts that drift far off, each with a pair that could touch it.
SolverWork WorkOfAMover(int num_far) {
  World world;
  const int mover = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.06}}, BoxMass(0.5, {0.1, 0.1, 0.1}),
                                     {{0.1, 0, 0}, {0, 0, -0.2}});
  const int pair = world.AddContactPair(mover, world.world_body()).value();
  core::ContactSet set;
  set.friction = 0.3f;
  std::uint32_t id = 0;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) test::AddPlane(&set, ++id, {x, y, -0.05}, {0, 0, 0}, {0, 0, 1}, 5e3);
  }
  for (int i = 0; i < num_far; ++i) {
    const int far = test::AddDynamic(&world, {{1, 0, 0, 0}, {10.0 + i, 0, 0}}, BoxMass(1.0, {0.1, 0.1, 0.1}),
                                     {{0.1, 0.2, 0.3}, {0.01, 0, 0}});
    EXPECT_TRUE(world.AddContactPair(far, mover).has_value());
  }
  for (int i = 0; i < 500; ++i) {
    world.SetContactPlanes(pair, set);
    world.Step(kDt);
  }
  EXPECT_GT(world.V_WO(mover).linear_m_per_s.z, 0.0) << "it has bounced";
  return world.solver_work();
}

TEST(Reference, FiftyFarPartsAddNoWorkToTheSolver) {
  const SolverWork alone = WorkOfAMover(0);
  const SolverWork among = WorkOfAMover(50);
  EXPECT_GT(alone.num_rows, 0u);
  EXPECT_EQ(among.num_islands, alone.num_islands);
  EXPECT_EQ(among.num_rows, alone.num_rows);
  EXPECT_EQ(among.num_sweeps, alone.num_sweeps);
  EXPECT_EQ(among.num_row_updates, alone.num_row_updates);
  EXPECT_EQ(among.num_direct_solves, alone.num_direct_solves);
}

}  // namespace
}  // namespace physics
