#include "hug/arm_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hug/noise.hpp"

namespace hug {
namespace {

Joints Random(Noise* noise, double size) {
  Joints values;
  for (double& value : values) value = size * (2.0 * noise->Even() - 1.0);
  return values;
}

const core::Pose kBase{core::QuaternionFromRollPitchYaw({0.0, 0.0, 0.7}), {0.3, -0.2, 0.1}};

physics::Chain ChainOf(const ArmModel& model) {
  return std::move(*physics::Chain::Create(model.links));
}

TEST(ArmModel, HasTheFlangeWhereTheDenavitHartenbergTableHasIt) {
  ArmDynamics arm(LightWeightRobot({{}, 0.4}));
  Noise noise(1);
  for (int i = 0; i < 50; ++i) {
    const Joints q = Random(&noise, 2.0);
    arm.Place({}, q, {});
    const core::Pose X_BF = DenavitHartenbergX_BF(q);
    EXPECT_LT(glm::length(arm.X_WD().translation - X_BF.translation), 1e-12);
    EXPECT_LT(glm::length(core::RotationVector(arm.X_WD().rotation * glm::conjugate(X_BF.rotation))), 1e-7);
  }
}

TEST(ArmModel, HoldsItsHandDownInTheReadyPosture) {
  ArmDynamics arm(LightWeightRobot({}));
  arm.Place({}, arm.model().ready, {});
  EXPECT_NEAR(arm.X_WD().rotate({0, 0, 1}).z, -1.0, 1e-12);
  EXPECT_GT(arm.X_WD().translation.x, 0.5);
  double sum_kg = 0.0;
  for (const physics::ChainLink& link : arm.model().links) sum_kg += link.mass.mass_kg;
  EXPECT_NEAR(sum_kg, 14.5 + arm.model().mount.mass_kg, 1e-9);
}

// Central differences of the pose: error h^2, here 1e-10.
TEST(ArmDynamics, JacobianIsTheDerivativeOfThePose) {
  ArmDynamics arm(LightWeightRobot({}));
  Noise noise(2);
  for (int i = 0; i < 20; ++i) {
    const Joints q = Random(&noise, 2.0);
    for (std::size_t k = 0; k < kJoints; ++k) {
      constexpr double kStep = 1e-5;
      Joints more = q, less = q;
      more[k] += kStep;
      less[k] -= kStep;
      arm.Place(kBase, more, {});
      const core::Pose X_more = arm.X_WD();
      arm.Place(kBase, less, {});
      const core::Pose X_less = arm.X_WD();
      arm.Place(kBase, q, {});
      const glm::dvec3 v = (X_more.translation - X_less.translation) / (2.0 * kStep);
      const glm::dvec3 w = core::RotationVector(X_more.rotation * glm::conjugate(X_less.rotation)) / (2.0 * kStep);
      EXPECT_LT(glm::length(arm.Column(k).linear_m_per_s - v), 1e-8);
      EXPECT_LT(glm::length(arm.Column(k).angular_rad_per_s - w), 1e-8);
    }
  }
}

TEST(ArmDynamics, BiasAccelerationIsTheChangeOfTheVelocityAtConstantJointSpeeds) {
  ArmDynamics arm(LightWeightRobot({}));
  Noise noise(3);
  for (int i = 0; i < 20; ++i) {
    const Joints q = Random(&noise, 2.0), speed = Random(&noise, 1.5);
    constexpr double kStep_s = 1e-5;
    arm.Place(kBase, q + kStep_s * speed, speed);
    const core::Twist after = arm.V_WD();
    arm.Place(kBase, q - kStep_s * speed, speed);
    const core::Twist before = arm.V_WD();
    arm.Place(kBase, q, speed);
    const core::Twist a = arm.BiasAcceleration();
    EXPECT_LT(glm::length(a.linear_m_per_s - (after.linear_m_per_s - before.linear_m_per_s) / (2 * kStep_s)), 1e-7);
    EXPECT_LT(glm::length(a.angular_rad_per_s - (after.angular_rad_per_s - before.angular_rad_per_s) / (2 * kStep_s)),
              1e-7);
  }
}

// Newton and Euler against the articulated-body algorithm of physics::Chain: one gives torques for accelerations, the
// other accelerations for torques.
TEST(ArmDynamics, InverseDynamicsUndoesTheForwardDynamicsOfTheChain) {
  ArmModel model = LightWeightRobot({});
  for (physics::ChainLink& link : model.links) link.damping = 0.0;
  ArmDynamics arm(model);
  physics::Chain chain = ChainOf(model);
  physics::ChainState state = chain.MakeState();
  state.X_WB = kBase;
  Noise noise(4);
  for (int i = 0; i < 50; ++i) {
    const Joints q = Random(&noise, 2.0), speed = Random(&noise, 2.0), torque = Random(&noise, 50.0);
    std::copy(q.begin(), q.end(), state.position.begin());
    std::copy(speed.begin(), speed.end(), state.speed.begin());
    physics::ChainAcceleration a;
    a.joint.resize(kJoints);
    std::vector<core::Wrench> weight(kJoints);
    chain.Place(state);
    for (std::size_t k = 0; k < kJoints; ++k) {
      weight[k].force_N = {0.0, 0.0, -chain.link(k).mass.mass_kg * kGravity_m_per_s2};
      weight[k].torque_Nm = glm::cross(chain.X_WL(k).rotate(chain.link(k).mass.p_OCm_m), weight[k].force_N);
    }
    chain.Accelerate(state, torque, weight, &a);
    arm.Place(kBase, q, speed);
    Joints acceleration;
    std::copy(a.joint.begin(), a.joint.end(), acceleration.begin());
    const Joints needed = arm.InverseDynamics(acceleration);
    for (std::size_t k = 0; k < kJoints; ++k) EXPECT_NEAR(needed[k], torque[k], 1e-9);
  }
}

// Power of the motors is the change of kinetic and potential energy: at q'' = 0 and the speeds q', d/dt of both.
TEST(ArmDynamics, PowerOfTheTorquesIsTheChangeOfEnergy) {
  const ArmModel model = LightWeightRobot({});
  ArmDynamics arm(model);
  physics::Chain chain = ChainOf(model);
  physics::ChainState state = chain.MakeState();
  const auto energy_J = [&](const Joints& q, const Joints& speed) {
    std::copy(q.begin(), q.end(), state.position.begin());
    std::copy(speed.begin(), speed.end(), state.speed.begin());
    double sum_J = chain.KineticEnergy_J(state);
    for (std::size_t k = 0; k < kJoints; ++k) {
      const physics::MassProperties& mass = chain.link(k).mass;
      sum_J += mass.mass_kg * kGravity_m_per_s2 * (chain.X_WL(k) * mass.p_OCm_m).z;
    }
    return sum_J;
  };
  Noise noise(5);
  for (int i = 0; i < 20; ++i) {
    const Joints q = Random(&noise, 2.0), speed = Random(&noise, 1.5), acceleration = Random(&noise, 3.0);
    arm.Place({}, q, speed);
    const Joints torque = arm.InverseDynamics(acceleration);
    double power_W = 0.0;
    for (std::size_t k = 0; k < kJoints; ++k) power_W += torque[k] * speed[k];
    constexpr double kStep_s = 1e-5;
    const Joints bend = (0.5 * kStep_s * kStep_s) * acceleration;
    const double after = energy_J(q + kStep_s * speed + bend, speed + kStep_s * acceleration);
    const double before = energy_J(q - kStep_s * speed + bend, speed - kStep_s * acceleration);
    EXPECT_NEAR(power_W, (after - before) / (2.0 * kStep_s), 1e-4 * (1.0 + std::abs(power_W)));
  }
}

TEST(ArmDynamics, NullSpaceMovesTheElbowAndNotTheHand) {
  ArmDynamics arm(LightWeightRobot({}));
  arm.Place(kBase, arm.model().ready, {});
  Joints v{0.3, -0.1, 0.5, 0.2, -0.4, 0.1, 0.2};
  v = arm.NullSpaceOf(v);
  core::Twist twist;
  double size = 0.0;
  for (std::size_t k = 0; k < kJoints; ++k) {
    twist.linear_m_per_s += v[k] * arm.Column(k).linear_m_per_s;
    twist.angular_rad_per_s += v[k] * arm.Column(k).angular_rad_per_s;
    size += v[k] * v[k];
  }
  EXPECT_GT(std::sqrt(size), 0.1);
  EXPECT_LT(glm::length(twist.linear_m_per_s), 1e-4);
  EXPECT_LT(glm::length(twist.angular_rad_per_s), 1e-3);
}

TEST(ArmDynamics, WrenchOfTorquesOfAWrenchIsTheWrench) {
  ArmDynamics arm(LightWeightRobot({}));
  arm.Place(kBase, arm.model().ready, {});
  const core::Wrench F{{3.0, -5.0, 8.0}, {0.2, 0.5, -0.4}};
  const core::Wrench back = arm.WrenchOf(arm.TorquesOf(F));
  EXPECT_LT(glm::length(back.force_N - F.force_N), 1e-2);
  EXPECT_LT(glm::length(back.torque_Nm - F.torque_Nm), 2e-3);
}

}  // namespace
}  // namespace hug
