#include <cmath>
#include <numbers>

#include "physics/chain/chain.hpp"
#include "physics/hinge.hpp"
#include "physics/slider.hpp"
#include "physics/spring_coupling.hpp"
#include "physics/testing/bodies.hpp"
#include "physics/testing/chain_samples.hpp"

namespace physics {
namespace {

using test::kDt;

double Energy_J(const World& world) {
  double sum_J = 0.0;
  for (std::size_t i = 0; i < world.num_bodies(); ++i) {
    if (world.kind(static_cast<int>(i)) == BodyKind::kDynamic) sum_J += world.kinetic_energy_J(static_cast<int>(i));
  }
  return sum_J;
}

glm::dvec3 Momentum_Ns(const World& world) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < world.num_bodies(); ++i) {
    if (world.kind(static_cast<int>(i)) == BodyKind::kDynamic) sum += world.momentum_Ns(static_cast<int>(i));
  }
  return sum;
}

glm::dvec3 AngularMomentum_Nms(const World& world) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < world.num_bodies(); ++i) {
    const int body = static_cast<int>(i);
    if (world.kind(body) != BodyKind::kDynamic) continue;
    sum += world.spin_Nms(body) + glm::cross(world.center_of_mass_W(body), world.momentum_Ns(body));
  }
  return sum;
}

TEST(Joints, APendulumWithoutFrictionKeepsItsEnergy) {
  World world;
  HingeParams params;
  params.X_CJ.translation = {-0.3, 0.02, 0.05};
  const int arm =
      test::AddDynamic(&world, HingePose(params, 0.4), BoxMass(1.0, {0.6, 0.05, 0.05}),
                       {{0, 0, 3.0}, glm::cross(glm::dvec3(0, 0, 3.0), HingePose(params, 0.4).translation)});
  trials::AddMechanism<Hinge>(&world, world.world_body(), arm, params);
  const double energy_J = Energy_J(world);
  for (int i = 0; i < 10000; ++i) world.Step(kDt);
  EXPECT_NEAR(Energy_J(world) / energy_J, 1.0, 1e-5);
  const double turns = std::remainder(0.4 + 3.0 * 10.0, 2.0 * std::numbers::pi);
  EXPECT_NEAR(world.mechanism(0).position(), turns, 5e-3);
}

// The links of a chain as bodies of a world, connected by hinges and sliders.
struct BodyArm {
  World world;
  int base = 0;
  std::vector<int> bodies;
  std::vector<int> joints;

  BodyArm(Chain* chain, const ChainState& state, const std::optional<MassProperties>& base_mass) {
    if (base_mass) base = test::AddDynamic(&world, state.X_WB, *base_mass, state.V_WB);
    chain->Place(state);
    for (std::size_t i = 0; i < chain->num_joints(); ++i) {
      const ChainLink& link = chain->link(i);
      bodies.push_back(test::AddDynamic(&world, chain->X_WL(i), link.mass, chain->V_WL(i)));
      const int parent = link.parent < 0 ? base : bodies[static_cast<std::size_t>(link.parent)];
      joints.push_back(static_cast<int>(i));
      if (link.is_prismatic) {
        trials::AddMechanism<Slider>(&world, parent, bodies.back(), SliderParams{link.X_PJ, {}, {}});
      } else {
        trials::AddMechanism<Hinge>(&world, parent, bodies.back(), HingeParams{link.X_PJ, {}, {}, false, {0, 0}, 0.0});
      }
    }
  }
};

Chain MakeChain(std::vector<ChainLink> links, std::optional<MassProperties> base) {
  auto chain = Chain::Create(std::move(links), base);
  EXPECT_TRUE(chain.has_value());
  return std::move(*chain);
}

TEST(Joints, ArmOfJointedBodiesMovesLikeTheChainInReducedCoordinates) {
  test::Draws draws(21);
  for (const bool is_free : {false, true}) {
    std::vector<ChainLink> links = test::RandomArm(&draws);
    links[4].is_prismatic = true;
    std::optional<MassProperties> base;
    if (is_free) base = BoxMass(20.0, {0.5, 0.5, 0.5});
    Chain chain = MakeChain(links, base);
    ChainState state = test::RandomState(chain, &draws);
    for (double& speed : state.speed) speed *= 0.5;
    BodyArm arm(&chain, state, base);
    const double energy_J = Energy_J(arm.world);
    const glm::dvec3 momentum = Momentum_Ns(arm.world);
    const glm::dvec3 angular = AngularMomentum_Nms(arm.world);
    const std::vector<double> none(7, 0.0);
    double apart_m = 0.0, largest = 0.0, least = 1e9;
    for (int i = 0; i < 1000; ++i) {
      arm.world.Step(kDt);
      chain.Step(kDt, none, {}, &state);
      largest = std::max(largest, Energy_J(arm.world) / energy_J);
      least = std::min(least, Energy_J(arm.world) / energy_J);
    }
    chain.Place(state);
    for (std::size_t i = 0; i < 7; ++i) {
      apart_m = std::max(apart_m, glm::length(chain.X_WL(i).translation - arm.world.X_WO(arm.bodies[i]).translation));
    }
    RecordProperty(is_free ? "apart_free_um" : "apart_um", std::to_string(apart_m * 1e6));
    EXPECT_LT(apart_m, 1e-6);
    EXPECT_LT(largest, 1.0 + 1e-6);
    EXPECT_GT(least, 1.0 - 1e-6);
    EXPECT_EQ(arm.world.num_fallbacks(), 0u);
    if (is_free) {
      EXPECT_LT(glm::length(Momentum_Ns(arm.world) - momentum), 1e-12 * glm::length(momentum));
      EXPECT_LT(glm::length(AngularMomentum_Nms(arm.world) - angular), 1e-12 * glm::length(angular));
    }
  }
}

// A free servicer with two arms whose joints have brakes and limits: one hand shakes the left arm, and the right arm's
// last link pushes a free block through contact planes.
TEST(Joints, TwoArmsOnAFreeBaseCarryAHandAndContactWithoutLosingMomentum) {
  test::Draws draws(22);
  std::vector<ChainLink> links = test::RandomArm(&draws);
  for (ChainLink link : test::RandomArm(&draws)) {
    link.parent = link.parent < 0 ? -1 : link.parent + 7;
    links.push_back(link);
  }
  const MassProperties base = BoxMass(60.0, {0.8, 0.6, 0.5});
  Chain chain = MakeChain(links, base);
  const ChainState state = chain.MakeState();
  chain.Place(state);
  World world;
  const int servicer = test::AddDynamic(&world, {}, base);
  std::vector<int> bodies;
  for (std::size_t i = 0; i < links.size(); ++i) {
    bodies.push_back(test::AddDynamic(&world, chain.X_WL(i), links[i].mass));
    HingeParams joint;
    joint.X_PJ = links[i].X_PJ;
    joint.axis.lower = -0.4;
    joint.axis.upper = 0.4;
    joint.axis.motor_limit = 0.2;
    const int parent = links[i].parent < 0 ? servicer : bodies[static_cast<std::size_t>(links[i].parent)];
    trials::AddMechanism<Hinge>(&world, parent, bodies.back(), joint);
  }
  const core::Pose X_WTool = world.X_WO(bodies[6]);
  const int hand = test::MustAdd(&world, BodyParams{BodyKind::kKinematic, X_WTool, {}, {}});
  auto* grip = trials::AddMechanism<SpringCoupling>(&world, hand, bodies[6], SpringCouplingParams{});
  grip->Attach(X_WTool, X_WTool, X_WTool.translation);
  const core::Pose X_WPusher = world.X_WO(bodies[13]);
  const int block = test::AddDynamic(&world, {{1, 0, 0, 0}, X_WPusher.translation + glm::dvec3(0, 0, 0.08)},
                                     BoxMass(2.0, {0.1, 0.1, 0.1}), {{}, {0, 0, -0.05}});
  const int contact = world.AddContactPair(block, bodies[13]).value();
  core::ContactSet set;
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 corner(i % 2 == 0 ? -0.05 : 0.05, i / 2 == 0 ? -0.05 : 0.05, -0.05);
    const glm::dvec3 n_G = glm::conjugate(X_WPusher.rotation) * glm::dvec3(0, 0, 1);
    test::AddPlane(&set, static_cast<std::uint32_t>(i), corner, 0.02 * n_G, n_G, 5000.0);
  }
  set.friction = 0.3;
  world.SetContactPlanes(contact, set);

  glm::dvec3 given_Ns(0.0);
  glm::dvec3 given_Nms(0.0);
  const glm::dvec3 angular_before = AngularMomentum_Nms(world);
  const glm::dvec3 momentum_before = Momentum_Ns(world);
  double sum_Ns = 0.0;
  bool has_pushed = false;
  for (int i = 0; i < 4000; ++i) {
    const double t = i * kDt;
    core::Pose X_WH = X_WTool;
    X_WH.translation +=
        glm::dvec3(0.08 * std::sin(5.0 * t), 0.06 * std::sin(7.0 * t), 0.07 * (1.0 - std::cos(3.0 * t)));
    world.SetKinematic(hand, X_WH, {{}, {0.4 * std::cos(5.0 * t), 0.42 * std::cos(7.0 * t), 0.21 * std::sin(3.0 * t)}});
    world.Step(kDt);
    const core::Wrench on_hand = world.MechanismForceOnParent(14, {});  // about W's origin
    given_Ns -= kDt * on_hand.force_N;
    given_Nms -= kDt * on_hand.torque_Nm;
    sum_Ns += kDt * glm::length(on_hand.force_N);
    has_pushed = has_pushed || world.contact(contact).num_pushing > 0;
  }
  EXPECT_TRUE(has_pushed);
  EXPECT_GT(sum_Ns, 10.0);
  EXPECT_LT(glm::length(Momentum_Ns(world) - momentum_before - given_Ns), 1e-9 * sum_Ns);
  EXPECT_LT(glm::length(AngularMomentum_Nms(world) - angular_before - given_Nms), 1e-9 * sum_Ns);
  EXPECT_LT(world.impulse_balance().relative(), 1e-9);
  EXPECT_EQ(world.num_fallbacks(), 0u);
  for (int i = 0; i < 14; ++i) {
    EXPECT_LT(std::abs(world.mechanism(i).position()), 0.4001) << i;
    const ChainLink& link = links[static_cast<std::size_t>(i)];
    const int parent = link.parent < 0 ? servicer : bodies[static_cast<std::size_t>(link.parent)];
    const glm::dvec3 apart =
        (world.X_WO(parent) * link.X_PJ).translation - world.X_WO(bodies[static_cast<std::size_t>(i)]).translation;
    EXPECT_LT(glm::length(apart), 1e-6) << i;
  }
}

// A screwdriver in zero gravity: its body free, its bit a hinge with a motor, a screw's resistance on the bit.
struct Screwdriver {
  World world;
  int body = -1, bit = -1, resistance = -1;
  explicit Screwdriver(double speed_rad_per_s, double torque_Nm) {
    HingeParams params;
    params.axis.motor_speed = speed_rad_per_s;
    params.axis.motor_limit = torque_Nm;
    body = test::AddDynamic(&world, {}, BoxMass(1.5, {0.06, 0.06, 0.2}));
    bit = test::AddDynamic(&world, {{1, 0, 0, 0}, {0, 0, 0.15}}, BoxMass(0.05, {0.008, 0.008, 0.1}));
    params.X_PJ.translation = {0, 0, 0.15};
    trials::AddMechanism<Hinge>(&world, body, bit, params);
    resistance = world.AddContactPair(bit, world.world_body()).value();
  }
  [[nodiscard]] double Spin() const {
    return world.V_WO(bit).angular_rad_per_s.z - world.V_WO(body).angular_rad_per_s.z;
  }
};

TEST(Motor, TurnsAtItsSpeedUpToItsTorqueAndStallsBeyond) {
  Screwdriver driver(10.0, 0.8);
  driver.world.SetContactWrench(driver.resistance, {{}, {0, 0, -1e-4}});
  for (int i = 0; i < 20; ++i) driver.world.Step(kDt);
  EXPECT_NEAR(driver.Spin(), 10.0, 1e-6);
  const glm::dvec3 before = AngularMomentum_Nms(driver.world);
  driver.world.SetContactWrench(driver.resistance, {{}, {0, 0, -2.0}});  // more than the motor has
  driver.world.Step(kDt);
  EXPECT_NEAR(driver.world.mechanism(0).force(), 0.8, 1e-9);
  EXPECT_LT(driver.Spin(), 10.0);
  // The body receives the motor's reaction: the total angular momentum changes by the screw's torque alone.
  EXPECT_LT(glm::length(AngularMomentum_Nms(driver.world) - before - glm::dvec3(0, 0, -2.0 * kDt)), 1e-12);
}

TEST(Motor, RestsWhileItsAxisIsLocked) {
  Screwdriver driver(10.0, 0.8);
  for (int i = 0; i < 20; ++i) driver.world.Step(kDt);
  driver.world.BeginChange(0, driver.world.FindTunable(0, "locked"), {1.0});
  driver.world.Step(kDt);
  const double held = driver.world.mechanism(0).position();
  driver.world.SetContactWrench(driver.resistance, {{}, {0, 0, -2.0}});
  for (int i = 0; i < 200; ++i) driver.world.Step(kDt);
  EXPECT_NEAR(driver.world.mechanism(0).position(), held, 1e-9);
  EXPECT_GT(driver.world.mechanism(0).force(), 1.0);  // the torque that the stalled bit still transmits
}

TEST(Motor, ReversesWhenItsSpeedIsChangedWhileRunning) {
  Screwdriver driver(10.0, 0.8);
  for (int i = 0; i < 20; ++i) driver.world.Step(kDt);
  driver.world.BeginChange(0, driver.world.FindTunable(0, "motor_rad_per_s"), {-10.0, ChangeMode::kRamped, 0.1});
  for (int i = 0; i < 50; ++i) driver.world.Step(kDt);
  EXPECT_NEAR(driver.Spin(), 0.0, 1e-6);
  for (int i = 0; i < 100; ++i) driver.world.Step(kDt);
  EXPECT_NEAR(driver.Spin(), -10.0, 1e-6);
}

TEST(Slider, RunsFreelyAlongItsAxisAndStopsAtItsLimits) {
  World world;
  SliderParams params;
  params.X_PJ = {core::QuaternionFromRollPitchYaw({0.4, 0.9, -0.3}), {0.1, 0, 0}};
  params.X_CJ.translation = {0.02, 0, 0};
  params.axis.lower = -0.05;
  params.axis.upper = 0.08;
  const glm::dvec3 z_W = params.X_PJ.rotate({0, 0, 1});
  const int drawer =
      test::AddDynamic(&world, params.X_PJ * params.X_CJ.inverse(), BoxMass(2.0, {0.3, 0.2, 0.1}), {{}, 0.2 * z_W});
  trials::AddMechanism<Slider>(&world, world.world_body(), drawer, params);
  for (int i = 0; i < 300; ++i) world.Step(kDt);
  EXPECT_NEAR(world.mechanism(0).position(), 0.2 * 0.299, 1e-9);
  const int push = world.AddContactPair(drawer, world.world_body()).value();
  world.SetContactWrench(push, {20.0 * z_W + glm::dvec3(5, -40, 3), {1, 2, -1}});
  for (int i = 0; i < 1000; ++i) world.Step(kDt);
  EXPECT_NEAR(world.mechanism(0).position(), 0.08, 1e-6);
  const glm::dvec3 place = world.X_WO(drawer) * params.X_CJ.translation - params.X_PJ.translation;
  EXPECT_LT(glm::length(place - 0.08 * z_W), 1e-6);
  EXPECT_LT(glm::length(core::RotationVector(glm::conjugate(world.X_WO(drawer).rotation) * params.X_PJ.rotation)),
            1e-6);
}

TEST(Slider, OnATurningCarrierItKeepsMomentumAndEnergy) {
  World world;
  const int carrier = test::AddDynamic(&world, {}, BoxMass(5.0, {0.4, 0.3, 0.1}), {{0.3, 0.2, 1.0}, {}});
  SliderParams params;
  params.X_PJ = {core::QuaternionFromRollPitchYaw({0.0, 1.2, 0.3}), {0.1, 0.05, 0.05}};
  const core::Pose X_WC = params.X_PJ;
  const core::Twist V_WC{{0.3, 0.2, 1.0}, glm::cross(glm::dvec3(0.3, 0.2, 1.0), X_WC.translation)};
  const int block = test::AddDynamic(&world, X_WC, BoxMass(0.8, {0.05, 0.1, 0.15}), V_WC);
  trials::AddMechanism<Slider>(&world, carrier, block, params);
  const double energy_J = Energy_J(world);
  const glm::dvec3 momentum = Momentum_Ns(world);
  const glm::dvec3 angular = AngularMomentum_Nms(world);
  for (int i = 0; i < 2000; ++i) world.Step(kDt);
  EXPECT_GT(std::abs(world.mechanism(0).position()), 0.1);  // flung outwards
  EXPECT_NEAR(Energy_J(world) / energy_J, 1.0, 1e-5);
  EXPECT_LT(glm::length(Momentum_Ns(world) - momentum), 1e-12);
  EXPECT_LT(glm::length(AngularMomentum_Nms(world) - angular), 1e-12);
}

// A servo is a spring that gives way: under a torque T it stands T / k away from its target.
TEST(Servo, GivesWayByTheTorqueOverItsStiffness) {
  World world;
  HingeParams params;
  params.axis.lower = -2.0;
  params.axis.upper = 2.0;
  params.axis.motor_limit = 1.0;
  params.axis.servo_stiffness = 4.0;
  params.axis.servo_damping = 0.2;
  params.axis.servo_target = 0.5;
  const int link = test::AddDynamic(&world, HingePose(params, 0.0), BoxMass(0.1, {0.1, 0.1, 0.1}));
  Hinge* const hinge = trials::AddMechanism<Hinge>(&world, world.world_body(), link, params);
  for (int i = 0; i < 3000; ++i) world.Step(kDt);
  EXPECT_NEAR(hinge->position(), 0.5, 1e-6);
  world.SetLoad(link, {glm::dvec3(0.0), {0.0, 0.0, -0.6}});
  for (int i = 0; i < 3000; ++i) world.Step(kDt);
  EXPECT_NEAR(hinge->position(), 0.5 - 0.6 / 4.0, 1e-6);
  EXPECT_NEAR(hinge->force(), 0.6, 1e-6);
}

TEST(Servo, YieldsToMoreThanItsTorqueAndStopsAtTheJointsLimit) {
  World world;
  HingeParams params;
  params.axis.lower = -1.0;
  params.axis.upper = 1.0;
  params.axis.motor_limit = 1.0;
  params.axis.servo_stiffness = 400.0;
  params.axis.servo_damping = 0.2;
  const int link = test::AddDynamic(&world, HingePose(params, 0.0), BoxMass(0.1, {0.1, 0.1, 0.1}));
  Hinge* const hinge = trials::AddMechanism<Hinge>(&world, world.world_body(), link, params);
  world.SetLoad(link, {glm::dvec3(0.0), {0.0, 0.0, -0.99}});
  for (int i = 0; i < 1000; ++i) world.Step(kDt);
  EXPECT_NEAR(hinge->position(), -0.99 / 400.0, 1e-6);
  world.SetLoad(link, {glm::dvec3(0.0), {0.0, 0.0, -1.1}});
  for (int i = 0; i < 3000; ++i) world.Step(kDt);
  EXPECT_NEAR(hinge->position(), -1.0, 1e-6);
  hinge->SetServoTarget(5.0);  // beyond the limit: no farther than that
  world.SetLoad(link, {});
  for (int i = 0; i < 6000; ++i) world.Step(kDt);
  EXPECT_NEAR(hinge->position(), 1.0, 1e-6);
  EXPECT_NEAR(hinge->force(), 0.0, 1e-6);
}

}  // namespace
}  // namespace physics
