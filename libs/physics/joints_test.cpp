#include <cmath>
#include <numbers>

#include "physics/chain/chain.hpp"
#include "physics/chain/chain_samples.hpp"
#include "physics/hinge.hpp"
#include "physics/slider.hpp"
#include "physics/test_support.hpp"

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
  test::MustAddMechanism<Hinge>(&world, world.world_body(), arm, params);
  const double energy_J = Energy_J(world);
  for (int i = 0; i < 10000; ++i) world.Step(kDt);
  EXPECT_NEAR(Energy_J(world) / energy_J, 1.0, 1e-5);
  const double turns = std::remainder(0.4 + 3.0 * 10.0, 2.0 * std::numbers::pi);
  EXPECT_NEAR(world.mechanism(0).position(), turns, 5e-3);
}

// The links of a chain as bodies of a world that hinges and sliders hold together.
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
        test::MustAddMechanism<Slider>(&world, parent, bodies.back(), SliderParams{link.X_PJ, {}, {}});
      } else {
        test::MustAddMechanism<Hinge>(&world, parent, bodies.back(),
                                      HingeParams{link.X_PJ, {}, {}, false, {0, 0}, 0.0});
      }
    }
  }
};

Chain MakeChain(std::vector<ChainLink> links, std::optional<MassProperties> base) {
  auto chain = Chain::Create(std::move(links), base);
  EXPECT_TRUE(chain.has_value());
  return std::move(*chain);
}

TEST(Joints, AnArmOfBodiesMovesLikeTheChainInReducedCoordinates) {
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
    test::MustAddMechanism<Hinge>(&world, body, bit, params);
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
  // What the body gets is the motor's reaction: together they change by the screw's torque alone.
  EXPECT_LT(glm::length(AngularMomentum_Nms(driver.world) - before - glm::dvec3(0, 0, -2.0 * kDt)), 1e-12);
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
  test::MustAddMechanism<Slider>(&world, world.world_body(), drawer, params);
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
  test::MustAddMechanism<Slider>(&world, carrier, block, params);
  const double energy_J = Energy_J(world);
  const glm::dvec3 momentum = Momentum_Ns(world);
  const glm::dvec3 angular = AngularMomentum_Nms(world);
  for (int i = 0; i < 2000; ++i) world.Step(kDt);
  EXPECT_GT(std::abs(world.mechanism(0).position()), 0.1);  // flung outwards
  EXPECT_NEAR(Energy_J(world) / energy_J, 1.0, 1e-5);
  EXPECT_LT(glm::length(Momentum_Ns(world) - momentum), 1e-12);
  EXPECT_LT(glm::length(AngularMomentum_Nms(world) - angular), 1e-12);
}

}  // namespace
}  // namespace physics
