#include <cmath>

#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"

namespace physics {
namespace {

using test::kDt;

// A ball (radius r) above the plane z = 0 of a fixed body, as the one plane under its centre.
struct BallOnPlane {
  World world;
  int ball = -1;
  int pair = -1;
  static constexpr double kRadius = 0.03;

  BallOnPlane(double mass, double height, const glm::dvec3& velocity, double stiffness, double damping,
              double friction = 0.0, ContactKind kind = ContactKind::kCompliant) {
    MassProperties m;
    m.mass_kg = mass;
    m.I_Cm_O_kg_m2 = glm::dmat3(0.4 * mass * kRadius * kRadius);
    ball = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, kRadius + height}}, m, {{}, velocity});
    pair = world.AddContactPair(ball, world.world_body(), kind).value();
    SetPlane(stiffness, damping, friction);
  }
  void SetPlane(double stiffness, double damping, double friction) {
    core::ContactSet set;
    set.damping_N_s_per_m = static_cast<float>(damping);
    set.friction = static_cast<float>(friction);
    test::AddPlane(&set, 7, {0, 0, -kRadius}, {0, 0, 0}, {0, 0, 1}, stiffness);
    world.SetContactPlanes(pair, set);
  }
  [[nodiscard]] double depth() const { return kRadius - world.X_WO(ball).translation.z; }
};

// A constant force for tests: a kinematic carrier's wrench on the body.
void Push(World* world, int pair, const glm::dvec3& force) {
  world->SetContactWrench(pair, {force, {}});
}

TEST(Contact, PressedBallRestsAtDepthForceOverStiffness) {
  BallOnPlane scene(0.2, 0.0005, {}, 2.0e4, 20.0);
  const int push = scene.world.AddContactPair(scene.ball, scene.world.world_body()).value();
  Push(&scene.world, push, {0, 0, -8.0});
  for (int i = 0; i < 3000; ++i) scene.world.Step(kDt);
  EXPECT_NEAR(scene.depth(), 8.0 / 2.0e4, 1e-9);  // the plane's point is a float: 30 mm to 1e-9 m
  EXPECT_NEAR(scene.world.contact(scene.pair).F_So_W.force_N.z, 8.0, 1e-6);
}

// Fastest of the 0.5 kg within 2 s.
double Fastest_m_per_s(BallOnPlane* scene) {
  double fastest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    scene->world.Step(kDt);
    fastest = std::max(fastest, glm::length(scene->world.V_WO(scene->ball).linear_m_per_s));
  }
  return fastest;
}

TEST(Contact, PassiveSpringsThatNoWorkHasLoadedPartBodiesNoFasterThanHardContacts) {
  for (const double depth : {1e-4, 5e-3, 2e-2}) {
    for (const double mass : {0.02, 0.5, 50.0}) {
      BallOnPlane scene(mass, -depth, {}, 2e4, 20.0, 0.0, ContactKind::kPassive);
      EXPECT_LE(Fastest_m_per_s(&scene), 1.2 * 0.02) << depth << " m, " << mass << " kg";
      EXPECT_LT(scene.depth(), 1e-6 + 0.5 * depth) << depth << " m, " << mass << " kg";
    }
  }
}

TEST(Contact, PassiveSpringsGiveBackNoMoreThanWasPutInWhenTheyGrowStiffer) {
  BallOnPlane scene(0.5, 1e-3, {0, 0, -0.1}, 1e4, 0.0, 0.0, ContactKind::kPassive);
  bool has_grown = false;
  double last = 0.0;
  for (int i = 0; i < 200; ++i) {
    scene.world.Step(kDt);
    last = scene.world.V_WO(scene.ball).linear_m_per_s.z;
    if (!has_grown && last > -0.02) {
      has_grown = true;
      scene.SetPlane(1.5e4, 0.0, 0.0);
    }
  }
  EXPECT_LT(scene.depth(), 0.0);
  EXPECT_NEAR(last, 0.1, 1e-5);
}

TEST(Contact, PassiveSpringsHoldALoadThoughNoWorkHasLoadedThem) {
  BallOnPlane scene(0.5, -5e-3, {}, 2e4, 20.0, 0.0, ContactKind::kPassive);
  const int push = scene.world.AddContactPair(scene.ball, scene.world.world_body()).value();
  Push(&scene.world, push, {0, 0, -40.0});
  double deepest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    scene.world.Step(kDt);
    deepest = std::max(deepest, scene.depth());
  }
  EXPECT_LE(deepest, 5e-3);
  EXPECT_NEAR(scene.depth(), 40.0 / 2e4, 1e-5);
}

TEST(Contact, NeverPulls) {
  BallOnPlane scene(0.2, -0.002, {}, 2.0e4, 200.0);  // starts 2 mm deep, leaves fast: damping would pull
  for (int i = 0; i < 2000; ++i) {
    scene.world.Step(kDt);
    EXPECT_GE(scene.world.contact(scene.pair).F_So_W.force_N.z, 0.0);
  }
  EXPECT_GT(scene.world.V_WO(scene.ball).linear_m_per_s.z, 0.0);
}

TEST(Contact, ReboundNeverGainsEnergyForAnyMass) {
  for (const double mass : {0.001, 0.02, 0.2, 2.0, 20.0}) {
    BallOnPlane scene(mass, 0.001, {0, 0, -0.1}, 1.0e4, 0.0);
    for (int i = 0; i < 2000; ++i) scene.world.Step(kDt);
    EXPECT_LE(scene.world.V_WO(scene.ball).linear_m_per_s.z, 0.1 + 1e-12) << mass;
    EXPECT_GE(scene.world.V_WO(scene.ball).linear_m_per_s.z, 0.0) << mass;
  }
}

TEST(Contact, FastLightBodyDoesNotTunnelThroughThePlane) {
  // 2 m/s and 1 ms: 2 mm per step, four times the gap; no penetrating plane exists before it is too late.
  BallOnPlane scene(0.05, 0.0005, {0, 0, -2.0}, 2.0e6, 0.0);
  double deepest = 0.0;
  for (int i = 0; i < 100; ++i) {
    scene.world.Step(kDt);
    deepest = std::max(deepest, scene.depth());
  }
  EXPECT_LT(deepest, 1e-4);
}

TEST(Contact, CoulombFrictionStopsASlidingBallPatchAtMuTimesForce) {
  // Four planes under a plate pressed with 10 N and pushed sideways: sticks below mu N, slides above with the excess.
  for (const double side_N : {1.9, 3.0}) {
    World world;
    const int plate = test::AddDynamic(&world, {}, BoxMass(0.5, {0.2, 0.2, 0.02}));
    const int pair = world.AddContactPair(plate, world.world_body()).value();
    const int push = world.AddContactPair(plate, world.world_body()).value();
    core::ContactSet set;
    set.damping_N_s_per_m = 20.0f;
    set.friction = 0.2f;
    int id = 0;
    for (const double x : {-0.1, 0.1}) {
      for (const double y : {-0.1, 0.1}) {
        test::AddPlane(&set, static_cast<std::uint32_t>(id++), {x, y, -0.01}, {0, 0, -0.01}, {0, 0, 1}, 5000.0);
      }
    }
    world.SetContactPlanes(pair, set);
    Push(&world, push, {0, 0, -10.0});
    for (int i = 0; i < 500; ++i) world.Step(kDt);
    Push(&world, push, {side_N, 0, -10.0});
    // The push acts at the centre and friction 10 mm lower: the small tilt does not change the sum of forces.
    for (int i = 0; i < 1000; ++i) world.Step(kDt);
    const double v = world.V_WO(plate).linear_m_per_s.x;
    if (side_N < 2.0) {
      EXPECT_LT(std::abs(v), 1e-6);
    } else {
      EXPECT_NEAR(v, (side_N - 2.0) / 0.5 * 1.0, 0.02);
    }
  }
}

TEST(Contact, ContactForceActsOnceOnEachOfTwoFreeBodies) {
  // Two bodies that only an injected contact joins must be in one island and be solved once: a force of 10 N on one of
  // them, in contact or not, appears once in the sum of momenta.
  World world;
  const int a = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0}}, BoxMass(1.0, {0.1, 0.1, 0.1}));
  const int b = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.1, 0, 0}}, BoxMass(2.0, {0.1, 0.1, 0.1}));
  const int push = world.AddContactPair(a, world.world_body()).value();
  core::ContactSet set;
  for (std::uint32_t i = 0; i < core::kMaxContactPlanes; ++i) {
    const double angle = 0.3 * i;
    test::AddPlane(&set, i, {0.05, 0.04 * std::cos(angle), 0.04 * std::sin(angle)}, {-0.05, 0, 0}, {-1, 0, 0}, 1e5);
  }
  std::vector<int> pairs;
  for (int i = 0; i < 8; ++i) {  // 160 contact points: more than Bullet's batch of 128
    pairs.push_back(world.AddContactPair(a, b).value());
    world.SetContactPlanes(pairs.back(), set);
  }
  world.SetContactWrench(push, {{10.0, 0, 0}, {}});
  for (int i = 0; i < 300; ++i) world.Step(kDt);
  EXPECT_NEAR(world.momentum_Ns(a).x + world.momentum_Ns(b).x, 3.0, 1e-12);
  EXPECT_NEAR(world.V_WO(a).linear_m_per_s.x, 1.0, 1e-3);
  EXPECT_NEAR(world.V_WO(b).linear_m_per_s.x, 1.0, 1e-3);
}

TEST(Contact, ImpactOfTwoSpinningBodiesKeepsMomentumAndAngularMomentum) {
  World world;
  const int a = test::AddDynamic(&world, {{1, 0, 0, 0}, {-0.06, 0.01, 0}}, BoxMass(1.0, {0.1, 0.12, 0.08}),
                                 {{0.3, -0.5, 0.7}, {0.4, 0.02, 0}});
  const int b =
      test::AddDynamic(&world, {{1, 0, 0, 0}, {0.06, 0, 0}}, BoxMass(0.3, {0.1, 0.07, 0.1}), {{-0.2, 0.1, 0.4}, {}});
  const int pair = world.AddContactPair(a, b).value();
  core::ContactSet set;
  set.friction = 0.4f;
  set.damping_N_s_per_m = 5.0f;
  test::AddPlane(&set, 1, {0.05, 0.02, 0.01}, {-0.05, 0, 0}, {-1, 0, 0}, 1e4);
  test::AddPlane(&set, 2, {0.05, -0.02, 0.02}, {-0.05, 0, 0}, {-1, 0, 0}, 1e4);
  world.SetContactPlanes(pair, set);
  const auto total = [&] {
    glm::dvec3 p(0.0);
    glm::dvec3 l(0.0);
    for (const int body : {a, b}) {
      p += world.momentum_Ns(body);
      l += world.spin_Nms(body) + glm::cross(world.center_of_mass_W(body), world.momentum_Ns(body));
    }
    return std::pair{p, l};
  };
  const auto before = total();
  for (int i = 0; i < 1000; ++i) world.Step(kDt);
  EXPECT_GT(world.V_WO(b).linear_m_per_s.x, 0.1);  // it was hit
  EXPECT_LT(glm::length(total().first - before.first), 1e-14);
  EXPECT_LT(glm::length(total().second - before.second), 1e-14);
  const ImpulseBalance balance = world.impulse_balance();
  EXPECT_GT(balance.linear_magnitude_Ns, 0.1);
  EXPECT_LT(balance.relative(), 1e-12);
  EXPECT_LT(balance.angular_residual_Nms / balance.angular_magnitude_Nms, 1e-12);
}

TEST(Contact, WrenchActsAtTheSamePointOnBothBodies) {
  World world;
  const int a = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.3, 0, 0}}, BoxMass(1.0, {0.1, 0.1, 0.1}));
  MassProperties mass = BoxMass(2.0, {0.1, 0.1, 0.2});
  mass.p_OCm_m = {0.01, 0.02, 0.03};
  const int b = test::AddDynamic(&world, {}, mass);
  const int pair = world.AddContactPair(a, b).value();
  world.SetContactWrench(pair, {{1.0, 2.0, -0.5}, {0.1, -0.2, 0.05}});
  for (int i = 0; i < 100; ++i) world.Step(kDt);
  const glm::dvec3 p = world.momentum_Ns(a) + world.momentum_Ns(b);
  const glm::dvec3 l = world.spin_Nms(a) + glm::cross(world.center_of_mass_W(a), world.momentum_Ns(a)) +
                       world.spin_Nms(b) + glm::cross(world.center_of_mass_W(b), world.momentum_Ns(b));
  EXPECT_LT(glm::length(p), 1e-14);
  EXPECT_LT(glm::length(l), 1e-14);
  EXPECT_NEAR(world.momentum_Ns(a).y, 0.2, 1e-12);
}

TEST(Contact, KinematicHandMovesAFreeBlockAtItsOwnSpeed) {
  World world;
  const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, {}, {}, {}});
  const int block = test::AddDynamic(&world, {{1, 0, 0, 0}, {0.1, 0, 0}}, BoxMass(0.5, {0.1, 0.1, 0.1}));
  const int pair = world.AddContactPair(hand, block).value();
  core::ContactSet set;
  set.damping_N_s_per_m = 20.0f;
  test::AddPlane(&set, 1, {0.05, 0, 0}, {-0.05, 0, 0}, {-1, 0, 0}, 2500.0);
  world.SetContactPlanes(pair, set);
  double x = 0.0;
  for (int i = 0; i < 2000; ++i) {
    x += 0.1 * kDt;
    world.SetKinematic(hand, {{1, 0, 0, 0}, {x, 0, 0}}, {{}, {0.1, 0, 0}});
    world.Step(kDt);
    // The block leaves with at most twice the hand's speed, that of an elastic impact.
    EXPECT_LE(world.V_WO(block).linear_m_per_s.x, 0.2 + 1e-9);
  }
  EXPECT_GT(world.V_WO(block).linear_m_per_s.x, 0.09);
  EXPECT_EQ(world.X_WO(hand).translation.x, x);
}

// Friction after one step on a body that is pressed with 10 N, mu = 0.5, where it has slipped from where it sticks.
double FrictionAfterSlip_N(ContactKind kind, double slip_m) {
  World world;
  const int body = test::AddDynamic(&world, {}, BoxMass(100.0, {0.1, 0.1, 0.1}));
  const int pair = world.AddContactPair(body, world.world_body(), kind).value();
  core::ContactSet set;
  set.friction = 0.5f;
  test::AddPlane(&set, 1, {0, 0, 0}, {-slip_m, 0, 0.001}, {0, 0, 1}, 1e4);
  world.SetContactPlanes(pair, set);
  world.Step(kDt);
  return world.contact(pair).F_So_W.force_N.x;
}

TEST(ElasticContact, PullsBackToWhereItSticksWithThePlanesStiffness) {
  EXPECT_NEAR(FrictionAfterSlip_N(ContactKind::kElastic, 0.0003), -3.0, 0.01);
  EXPECT_EQ(FrictionAfterSlip_N(ContactKind::kCompliant, 0.0003), 0.0);
}

TEST(ElasticContact, SlidesAtCoulombsLimit) {
  EXPECT_NEAR(FrictionAfterSlip_N(ContactKind::kElastic, 0.002), -5.0, 0.01);
}

TEST(Contact, TwoRunsAreBitForBitEqual) {
  const auto run = [] {
    BallOnPlane scene(0.2, 0.002, {0.1, 0.05, -0.3}, 2.0e4, 5.0, 0.3);
    for (int i = 0; i < 500; ++i) scene.world.Step(kDt);
    return scene.world.StateHash();
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace physics
