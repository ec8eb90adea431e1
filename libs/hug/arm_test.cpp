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

// An arm under admittance control in nobody's hand, which renders this body.
ArmFigures Rendering(const VirtualBody& body) {
  ArmFigures figures = Quiet();
  figures.hand = NoHand();
  figures.control.mode = ControlMode::kAdmittance;
  figures.control.body = body;
  return figures;
}

// A sine of force or torque on an arm for whole periods after the transient of time constant m / b has decayed to e^-6.
// `push` makes the wrench of its strength now, `place` reads the coordinate that it moves. Impedance F / v as a complex
// number; expected: b + j w m.
template <typename Push, typename Place>
std::complex<double> Rendered(ArmRig* rig, double hz, double amplitude, double decay_s, Push push, Place place) {
  rig->Engage();
  const double w = 2.0 * glm::pi<double>() * hz;
  const double begin_s = rig->arm.time_s();
  const double transient_s = std::ceil(6.0 * decay_s * hz) / hz;
  const double whole_s = std::max(std::ceil(hz), 2.0) / hz;
  std::complex<double> F_sum = 0.0, x_sum = 0.0;
  rig->at_each_step = [&] {
    const double t = rig->arm.time_s() - begin_s;
    const double F = amplitude * std::cos(w * t);
    rig->arm.PushBy(push(F));
    if (t < transient_s - 1e-9) return;
    const std::complex<double> turn = std::polar(1.0, -w * t);
    F_sum += turn * std::polar(1.0, -0.5 * w * Arm::kStep_s) * F;  // it is held for a step
    x_sum += turn * place();                                       // poses are not filtered, as velocities are
  };
  rig->Run(transient_s + whole_s);
  return F_sum / (x_sum * std::complex<double>(0.0, w));
}

std::complex<double> RenderedInTranslation(const VirtualBody& body, double hz, int axis) {
  ArmRig rig(Rendering(body));
  const double w = 2.0 * glm::pi<double>() * hz;
  const double amplitude_N = std::min(8.0, 0.01 * w * w * body.mass_kg);  // 1 cm at most
  const auto push = [axis](double F) {
    core::Wrench wrench;
    wrench.force_N[axis] = F;
    return wrench;
  };
  return Rendered(&rig, hz, amplitude_N, body.mass_kg / body.damping_N_s_per_m, push,
                  [&] { return rig.arm.X_WD().translation[axis]; });
}

std::complex<double> RenderedInRotation(const VirtualBody& body, double hz, int axis) {
  ArmRig rig(Rendering(body));
  const double w = 2.0 * glm::pi<double>() * hz;
  const double amplitude_Nm = std::min(1.0, 0.1 * w * w * body.inertia_kg_m2);  // 0.1 rad at most
  const auto push = [axis](double tau) {
    core::Wrench wrench;
    wrench.torque_Nm[axis] = tau;
    return wrench;
  };
  const glm::dquat R_begin = rig.hand.X_WT.rotation;
  return Rendered(&rig, hz, amplitude_Nm, body.inertia_kg_m2 / body.damping_Nm_s_per_rad, push,
                  [&] { return core::RotationVector(rig.arm.X_WD().rotation * glm::conjugate(R_begin))[axis]; });
}

// The default, and one with more damping.
const VirtualBody kBodies[] = {{}, {2.0, 0.03, 20.0, 0.5}};

TEST(HugArm, AdmittanceRendersMassAndDampingWithinFivePercentUpTo10Hz) {
  for (const VirtualBody& body : kBodies) {
    const double m = body.mass_kg, b = body.damping_N_s_per_m;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double hz : {1.0, 3.0, 10.0}) {
        const std::complex<double> Z = RenderedInTranslation(body, hz, axis);
        EXPECT_NEAR(Z.imag() / (2.0 * glm::pi<double>() * hz), m, 0.05 * m) << axis << " at " << hz << " Hz";
        EXPECT_NEAR(Z.real(), b, 0.05 * b) << axis << " at " << hz << " Hz";
      }
    }
  }
}

TEST(HugArm, AdmittanceRendersInertiaAndDampingOfRotationWithinFivePercentUpTo10Hz) {
  for (const VirtualBody& body : kBodies) {
    const double J = body.inertia_kg_m2, b = body.damping_Nm_s_per_rad;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double hz : {1.0, 3.0, 10.0}) {
        const std::complex<double> Z = RenderedInRotation(body, hz, axis);
        EXPECT_NEAR(Z.imag() / (2.0 * glm::pi<double>() * hz), J, 0.05 * J) << axis << " at " << hz << " Hz";
        EXPECT_NEAR(Z.real(), b, 0.05 * b) << axis << " at " << hz << " Hz";
      }
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
