#include "hug/arm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <glm/gtc/constants.hpp>

#include "hug/feed_forward.hpp"
#include "hug/testing/arm_rig.hpp"

namespace hug {
namespace {

ArmFigures Quiet() {  // sensors without noise, for comparisons with formulas
  ArmFigures figures;
  figures.sensors.force_noise_N = figures.sensors.wrist_torque_noise_Nm = figures.sensors.torque_noise_Nm = 0.0;
  figures.sensors.motor_step_rad = 1e-9;
  return figures;
}

double Away_m(const ArmRig& rig) {
  return glm::distance(rig.arm.X_WD().translation, rig.hand.X_WT.translation);
}

TEST(HugArm, EngagesAfterASecondOfGoodLinkWithoutAJump) {
  ArmRig rig{ArmFigures{}};
  ASSERT_TRUE(rig.starts);
  rig.Run(0.9);
  EXPECT_EQ(rig.arm.safety().state(), SafetyState::kIdle);
  rig.Run(0.2);
  EXPECT_EQ(rig.arm.safety().state(), SafetyState::kEngaging);
  double largest_m = 0.0;
  rig.at_each_step = [&] { largest_m = std::max(largest_m, Away_m(rig)); };
  rig.Run(1.2);
  EXPECT_EQ(rig.arm.safety().state(), SafetyState::kForce);
  EXPECT_TRUE(rig.arm.status().is_clutch_closed);
  EXPECT_LT(largest_m, 1e-3);
}

TEST(HugArm, CarriesItsWeightInAnyPosture) {
  for (const glm::dvec3& start_m : {glm::dvec3(0.6, 0.0, 0.2), {0.45, 0.3, 0.1}, {0.5, -0.35, 0.4}}) {
    ArmFigures figures;
    figures.hand = NoHand();
    figures.control.mode = ControlMode::kGravity;
    ArmRig rig(figures, start_m);
    ASSERT_TRUE(rig.starts);
    rig.Engage();
    rig.Run(1.0);
    EXPECT_EQ(rig.arm.safety().state(), SafetyState::kForce);
    EXPECT_LT(glm::length(rig.arm.V_WD().linear_m_per_s), 0.02);
    EXPECT_LT(Away_m(rig), 0.02);  // only noise of the sensors moves it
  }
}

TEST(HugArm, HasTheCommandedForceBalancedByTheHandAtRest) {
  ArmRig rig{Quiet()};
  rig.Engage();
  rig.command.F_Do_W = {{5.0, -8.0, 12.0}, {0.2, 0.3, -0.4}};
  rig.Run(3.0);
  const glm::dvec3 expected_m = rig.command.F_Do_W.force_N / 800.0;
  EXPECT_LT(glm::length(rig.arm.X_WD().translation - rig.hand.X_WT.translation - expected_m), 2e-4);
  EXPECT_LT(glm::length(rig.arm.hand_F_Do_W().force_N + rig.command.F_Do_W.force_N), 0.1);
  EXPECT_LT(glm::length(rig.arm.hand_F_Do_W().torque_Nm + rig.command.F_Do_W.torque_Nm), 0.02);
}

// A push of the hand accelerates by (1 + k) Lambda^-1, with the mount's mass m_p, that the sensor does not see move, in
// full: a = (E + m_p (1 + k) L)^-1 (1 + k) L F, with L of the arm without the mount. Measured over 5 ms.
TEST(HugArm, FeedForwardLeavesThirtyPercentOfTheInertia) {
  for (int axis = 0; axis < 3; ++axis) {
    ArmFigures figures = Quiet();
    figures.hand = NoHand();
    figures.mount.mass_kg = 0.0;
    figures.control.posture_per_s2 = figures.control.posture_per_s = 0.0;
    ArmRig rig(figures);
    rig.Engage();
    ArmDynamics arm = rig.arm.measured();
    const double raw_per_kg =
        arm.InverseApparentInertia()[static_cast<std::size_t>(axis + 3)][static_cast<std::size_t>(axis + 3)];
    core::Wrench push;
    push.force_N[axis] = 2.0;
    rig.arm.PushBy(push);
    const double before = rig.arm.V_WD().linear_m_per_s[axis];
    rig.Run(0.003);  // the speed's filter is behind
    const double v1 = rig.arm.V_WD().linear_m_per_s[axis];
    rig.Run(0.010);
    const double v2 = rig.arm.V_WD().linear_m_per_s[axis];
    EXPECT_LT(std::abs(before), 1e-4);
    const double share = 2.0 * raw_per_kg / ((v2 - v1) / 0.010);
    EXPECT_NEAR(share, 0.3, 0.02) << axis;
  }
}

// Impedance F / v at the hand by a sine of force, after the transient, as a complex number; expected b + j w m.
std::complex<double> Rendered(const ArmFigures& figures, double hz, int axis) {
  ArmRig rig(figures);
  rig.Engage();
  const double w = 2.0 * glm::pi<double>() * hz;
  const double begin_s = rig.arm.time_s();
  const double amplitude_N = std::min(8.0, 0.01 * w * w * 1.5);  // 1 cm at most
  const double transient_s = std::ceil(2.0 * hz) / hz;           // whole periods, with the decay of m / b = 0.3 s
  const double whole_s = std::max(std::ceil(hz), 2.0) / hz;
  std::complex<double> F_sum = 0.0, v_sum = 0.0;
  rig.at_each_step = [&] {
    const double t = rig.arm.time_s() - begin_s;
    core::Wrench push;
    push.force_N[axis] = amplitude_N * std::cos(w * t);
    rig.arm.PushBy(push);
    if (t < transient_s - 1e-9) return;
    const std::complex<double> turn = std::polar(1.0, -w * t);
    F_sum += turn * std::polar(1.0, -0.5 * w * Arm::kStep_s) * push.force_N[axis];  // it is held for a step
    // Velocity from the poses, which are not filtered.
    v_sum += turn * rig.arm.X_WD().translation[axis];
  };
  rig.Run(transient_s + whole_s);
  return F_sum / (v_sum * std::complex<double>(0.0, w));
}

TEST(HugArm, AdmittanceRendersMassAndDampingWithinFivePercentUpTo10Hz) {
  ArmFigures figures = Quiet();
  figures.hand = NoHand();
  figures.control.mode = ControlMode::kAdmittance;
  figures.control.body = {2.0, 0.03, 20.0, 0.05};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double hz : {1.0, 3.0, 10.0}) {
      const std::complex<double> Z = Rendered(figures, hz, axis);
      const double w = 2.0 * glm::pi<double>() * hz;
      EXPECT_NEAR(Z.imag() / w, 2.0, 0.1) << axis << " at " << hz << " Hz";
      EXPECT_NEAR(Z.real(), 20.0, 1.0) << axis << " at " << hz << " Hz";
    }
  }
}

// The same of a torque about an axis: tau / omega, expected b + j w J.
std::complex<double> RenderedInRotation(const ArmFigures& figures, double hz, int axis) {
  ArmRig rig(figures);
  rig.Engage();
  const double w = 2.0 * glm::pi<double>() * hz;
  const double begin_s = rig.arm.time_s();
  const glm::dquat R_begin = rig.arm.X_WD().rotation;
  const double amplitude_Nm = std::min(1.0, 0.1 * w * w * figures.control.body.inertia_kg_m2);  // 0.1 rad at most
  const double transient_s = std::ceil(2.0 * hz) / hz;
  const double whole_s = std::max(std::ceil(hz), 2.0) / hz;
  std::complex<double> tau_sum = 0.0, angle_sum = 0.0;
  rig.at_each_step = [&] {
    const double t = rig.arm.time_s() - begin_s;
    core::Wrench push;
    push.torque_Nm[axis] = amplitude_Nm * std::cos(w * t);
    rig.arm.PushBy(push);
    if (t < transient_s - 1e-9) return;
    const std::complex<double> turn = std::polar(1.0, -w * t);
    tau_sum += turn * std::polar(1.0, -0.5 * w * Arm::kStep_s) * push.torque_Nm[axis];
    angle_sum += turn * core::RotationVector(rig.arm.X_WD().rotation * glm::conjugate(R_begin))[axis];
  };
  rig.Run(transient_s + whole_s);
  return tau_sum / (angle_sum * std::complex<double>(0.0, w));
}

// The motion is 0.13 ms early: at 10 Hz that adds 0.016 Nm s/rad to the damping of this inertia, 3 % of the one here.
TEST(HugArm, AdmittanceRendersInertiaAndDampingOfRotationWithinFivePercentUpTo10Hz) {
  ArmFigures figures = Quiet();
  figures.hand = NoHand();
  figures.control.mode = ControlMode::kAdmittance;
  figures.control.body = {2.0, 0.03, 20.0, 0.5};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double hz : {1.0, 3.0, 10.0}) {
      const std::complex<double> Z = RenderedInRotation(figures, hz, axis);
      const double w = 2.0 * glm::pi<double>() * hz;
      EXPECT_NEAR(Z.imag() / w, 0.03, 0.0015) << axis << " at " << hz << " Hz";
      EXPECT_NEAR(Z.real(), 0.5, 0.025) << axis << " at " << hz << " Hz";
    }
  }
}

// The gain at which an arm with a mass in the hand, rigidly held, begins to swing: bisected on the arm of seven joints.
// The hand's mass is a point, so the limit is 1 + 1 / (m_h l) with l the largest eigenvalue of the translational block
// of J M^-1 J^T.
double LargestEigenvalue(const std::array<std::array<double, 6>, 6>& inverse, int first = 3) {
  glm::dvec3 v(0.3, 0.5, 0.8);
  double value = 0.0;
  for (int i = 0; i < 200; ++i) {
    glm::dvec3 next(0.0);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        next[r] += inverse[static_cast<std::size_t>(r + first)][static_cast<std::size_t>(c + first)] * v[c];
      }
    }
    value = glm::length(next);
    v = next / value;
  }
  return value;
}

bool Swings(double gain, double held_kg, double held_kg_m2 = 0.0) {
  ArmFigures figures = Quiet();
  figures.hand = NoHand();
  figures.mount.mass_kg = 0.0;
  figures.control.mode = ControlMode::kGravity;
  figures.control.share_of_inertia = 1.0 / (1.0 + gain);
  figures.sensors.force_gap_N = 1e9;  // the swing is to be seen, not caught
  ArmRig rig(figures);
  rig.arm.HoldBody(held_kg, held_kg_m2);
  core::Wrench push;
  push.force_N = {0.0, 0.0, held_kg * kGravity_m_per_s2};  // the hand carries its weight
  rig.arm.PushBy(push);
  rig.Engage();
  // The force is a step late, so what grows or decays changes its sign with each step.
  const bool turns = held_kg_m2 > 0.0;
  const auto felt = [&] { return turns ? rig.arm.readings().F_Do_W.torque_Nm : rig.arm.readings().F_Do_W.force_N; };
  glm::dvec3 before = felt();
  const auto swing_N = [&] {
    double most_N = 0.0;
    for (int i = 0; i < 12; ++i) {
      rig.Run(Arm::kStep_s);
      most_N = std::max(most_N, glm::distance(felt(), before));
      before = felt();
    }
    return most_N;
  };
  const glm::dvec3 knock(turns ? 0.02 : 0.3);
  rig.arm.PushBy(turns ? core::Wrench{push.force_N, knock} : core::Wrench{push.force_N + knock, {}});
  rig.Run(Arm::kStep_s);
  rig.arm.PushBy(push);
  rig.Run(0.03);
  const double early_N = swing_N();
  rig.Run(0.06);
  return swing_N() > early_N;
}

TEST(HugArm, FeedForwardIsStableUpToTheLimitOfTheTheory) {
  constexpr double kHeld_kg = 1.5;
  ArmFigures figures = Quiet();
  figures.mount.mass_kg = 0.0;
  ArmRig rig(figures);
  ArmDynamics arm = rig.arm.measured();
  const double limit = LargestStableGain(1.0 / LargestEigenvalue(arm.InverseApparentInertia()), kHeld_kg);
  EXPECT_FALSE(Swings(0.98 * limit, kHeld_kg)) << limit;
  EXPECT_TRUE(Swings(1.02 * limit, kHeld_kg)) << limit;
}

// In rotation the same with inertias: 1 + J / J_h. What the hand holds has no mass here, so that only turning it feeds
// back.
TEST(HugArm, FeedForwardInRotationIsStableUpToTheLimitOfTheTheory) {
  constexpr double kHeld_kg_m2 = 0.1;
  ArmFigures figures = Quiet();
  figures.mount.mass_kg = 0.0;
  ArmRig rig(figures);
  ArmDynamics arm = rig.arm.measured();
  const double limit = LargestStableGain(1.0 / LargestEigenvalue(arm.InverseApparentInertia(), 0), kHeld_kg_m2);
  EXPECT_FALSE(Swings(0.98 * limit, 0.0, kHeld_kg_m2)) << limit;
  EXPECT_TRUE(Swings(1.02 * limit, 0.0, kHeld_kg_m2)) << limit;
}

}  // namespace
}  // namespace hug
