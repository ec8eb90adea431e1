#include "physics/chain/chain.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "physics/testing/chain_samples.hpp"
#include "physics/testing/closed_form/two_link_arm.hpp"

namespace physics {
namespace {

using test::Draws;

Chain Make(std::vector<ChainLink> links, std::optional<MassProperties> base = std::nullopt) {
  auto chain = Chain::Create(std::move(links), base);
  EXPECT_TRUE(chain.has_value()) << (chain ? "" : chain.error().detail);
  return std::move(*chain);
}

TEST(Chain, AccelerationsOfAPlanarArmEqualTheClosedForm) {
  Draws draws(3);
  for (int i = 0; i < 1000; ++i) {
    closed_form::TwoLinkArm arm;
    arm.length_1_m = draws.In(0.2, 0.6);
    arm.center_1_m = draws.In(0.05, 0.4);
    arm.mass_1_kg = draws.In(0.5, 5.0);
    arm.inertia_1_kg_m2 = draws.In(0.01, 0.1);
    arm.center_2_m = draws.In(0.05, 0.4);
    arm.mass_2_kg = draws.In(0.5, 5.0);
    arm.inertia_2_kg_m2 = draws.In(0.01, 0.1);
    std::vector<ChainLink> links(2);
    links[0].X_PJ = {draws.Rotation(), draws.Vector(1.0)};
    links[0].mass = {arm.mass_1_kg, {arm.center_1_m, 0, 0}, glm::dmat3(arm.inertia_1_kg_m2)};
    links[1].parent = 0;
    links[1].X_PJ.translation = {arm.length_1_m, 0, 0};
    links[1].mass = {arm.mass_2_kg, {arm.center_2_m, 0, 0}, glm::dmat3(arm.inertia_2_kg_m2)};
    Chain chain = Make(links);
    const ChainState state = test::RandomState(chain, &draws);
    const double torque[2] = {draws.In(-5.0, 5.0), draws.In(-5.0, 5.0)};
    ChainAcceleration found;
    found.joint.resize(2);
    chain.Accelerate(state, torque, {}, &found);
    const auto exact = closed_form::TwoLinkAccelerations(arm, {state.position[0], state.position[1]},
                                                         {state.speed[0], state.speed[1]}, {torque[0], torque[1]});
    const double scale = std::abs(exact[0]) + std::abs(exact[1]);
    EXPECT_NEAR(found.joint[0], exact[0], 1e-11 * scale);
    EXPECT_NEAR(found.joint[1], exact[1], 1e-11 * scale);
  }
}

TEST(Chain, AForceOnALinkActsAsJacobianTransposedTimesForce) {
  Draws draws(4);
  Chain chain = Make(test::RandomArm(&draws));
  for (int i = 0; i < 50; ++i) {
    const ChainState state = test::RandomState(chain, &draws);
    std::vector<core::Wrench> wrenches(7);
    const std::size_t link = static_cast<std::size_t>(i % 7);
    wrenches[link] = {draws.Vector(10.0), draws.Vector(2.0)};
    const std::vector<double> none(7, 0.0);
    ChainAcceleration pushed, driven;
    pushed.joint.resize(7);
    driven.joint.resize(7);
    chain.Accelerate(state, none, wrenches, &pushed);
    std::vector<double> columns(42);
    chain.Jacobian(link, columns);
    std::vector<double> torque(7);
    for (std::size_t k = 0; k < 7; ++k) {
      for (int c = 0; c < 3; ++c) {
        torque[k] += columns[6 * k + static_cast<std::size_t>(c)] * wrenches[link].torque_Nm[c] +
                     columns[6 * k + 3 + static_cast<std::size_t>(c)] * wrenches[link].force_N[c];
      }
    }
    chain.Accelerate(state, torque, {}, &driven);
    for (std::size_t k = 0; k < 7; ++k) {
      EXPECT_NEAR(pushed.joint[k], driven.joint[k], 1e-9 * (1.0 + std::abs(driven.joint[k])));
    }
  }
}

TEST(Chain, AFreeTwoArmedRobotKeepsEnergyAndMomentum) {
  Draws draws(5);
  std::vector<ChainLink> links = test::RandomArm(&draws);
  for (ChainLink link : test::RandomArm(&draws)) {
    link.parent = link.parent < 0 ? -1 : link.parent + 7;
    links.push_back(link);
  }
  links[3].is_prismatic = true;
  Chain chain = Make(links, BoxMass(40.0, {0.8, 0.6, 0.5}));
  ChainState state = test::RandomState(chain, &draws);
  for (double& speed : state.speed) speed *= 0.3;
  const double energy_J = chain.KineticEnergy_J(state);
  const Force momentum = chain.Momentum(state);
  const std::vector<double> none(14, 0.0);
  for (int i = 0; i < 2000; ++i) chain.Step(1e-3, none, {}, &state);
  EXPECT_NEAR(chain.KineticEnergy_J(state) / energy_J, 1.0, 1e-8);
  const Force after = chain.Momentum(state);
  EXPECT_LT(glm::length(after.force - momentum.force), 1e-9 * glm::length(momentum.force));
  EXPECT_LT(glm::length(after.torque - momentum.torque), 1e-9 * glm::length(momentum.torque));
}

TEST(Chain, WorkOfMotorsAndForcesEqualsTheChangeOfEnergy) {
  Draws draws(6);
  Chain chain = Make(test::RandomArm(&draws));
  ChainState state = chain.MakeState();
  const std::vector<double> torque{1.0, -2.0, 0.5, 0.3, -0.2, 0.1, 0.05};
  double work_J = 0.0;
  for (int i = 0; i < 500; ++i) {
    const std::vector<double> before = state.position;
    chain.Step(1e-3, torque, {}, &state);
    for (std::size_t k = 0; k < 7; ++k) work_J += torque[k] * (state.position[k] - before[k]);
  }
  EXPECT_GT(work_J, 0.1);
  EXPECT_NEAR(chain.KineticEnergy_J(state) / work_J, 1.0, 1e-6);
}

TEST(Chain, JointLimitsStopJointsWithoutChangingMomentum) {
  Draws draws(7);
  std::vector<ChainLink> links = test::RandomArm(&draws);
  for (ChainLink& link : links) {
    link.lower = -0.3;
    link.upper = 0.3;
  }
  Chain chain = Make(links, BoxMass(30.0, {0.6, 0.6, 0.6}));
  ChainState state = chain.MakeState();
  for (double& speed : state.speed) speed = draws.In(-2.0, 2.0);
  const Force momentum = chain.Momentum(state);
  const std::vector<double> none(7, 0.0);
  double energy_J = chain.KineticEnergy_J(state);
  int stops = 0;
  for (int i = 0; i < 2000; ++i) {
    chain.Step(1e-3, none, {}, &state);
    const double now_J = chain.KineticEnergy_J(state);
    EXPECT_LE(now_J, energy_J * (1.0 + 1e-4));  // resetting a position to its limit changes the inertia slightly
    if (now_J < 0.9999 * energy_J) ++stops;
    energy_J = now_J;
    for (const double position : state.position) ASSERT_LE(std::abs(position), 0.3);
  }
  EXPECT_GT(stops, 3);
  EXPECT_LT(glm::length(chain.Momentum(state).force - momentum.force), 2e-2 * glm::length(momentum.force));
}

TEST(Chain, RefusesInvalidParameters) {
  Draws draws(8);
  const std::vector<ChainLink> good = test::RandomArm(&draws);
  auto links = good;
  links[2].parent = 4;
  EXPECT_FALSE(Chain::Create(links).has_value());
  links = good;
  links[2].mass.mass_kg = 0.0;
  EXPECT_FALSE(Chain::Create(links).has_value());
  links = good;
  links[2].mass.I_Cm_O_kg_m2 = glm::dmat3(1, 0, 0, 0, 1, 0, 0, 0, 3);  // 1 + 1 < 3
  EXPECT_FALSE(Chain::Create(links).has_value());
  links = good;
  links[2].X_PJ.translation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Chain::Create(links).has_value());
  links = good;
  links[2].lower = 1.0;
  links[2].upper = 1.0;
  EXPECT_FALSE(Chain::Create(links).has_value());
}

}  // namespace
}  // namespace physics
