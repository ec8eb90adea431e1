#include "vps/coupling/virtual_coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vps/testing/case_random.hpp"
#include "vps/testing/pose_at.hpp"

namespace vps {
namespace {

TEST(SeparationStep, EqualsThePrintedFormWherePrintedIsFinite) {
  CaseRandom random(1);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 f = std::pow(10.0, random.Uniform(-6, 0)) * random.InCube();
    const glm::dvec3 t = std::pow(10.0, random.Uniform(-6, 0)) * random.InCube();
    const double sigma = 0.035;
    const double norm_f = glm::length(f);
    const double norm_t = glm::length(t);
    const glm::dvec3 phi = t / norm_t / (sigma * norm_f / norm_t + norm_t / norm_f);
    const glm::dvec3 x = f / norm_f * (sigma * norm_f / norm_t) * glm::length(phi);
    const SeparationStep step = ComputeSeparationStep({f, t}, sigma);
    EXPECT_LT(glm::length(step.delta_phi_per_m - phi), 1e-13 * (1 + glm::length(phi)));
    EXPECT_LT(glm::length(step.delta_x - x), 1e-13);
  }
}

TEST(SeparationStep, IsBounded) {
  CaseRandom random(2);
  for (int i = 0; i < 1000; ++i) {
    const SeparationStep step = ComputeSeparationStep(
        {1e-3 * random.InCube(), std::pow(10.0, random.Uniform(-7, -2)) * random.InCube()}, 0.035);
    EXPECT_LE(glm::length(step.delta_x), 1 + 1e-12);
    EXPECT_LE(glm::length(step.delta_phi_per_m), 1 / (2 * std::sqrt(0.035)) * (1 + 1e-12));
  }
}

TEST(SeparationStep, IsZeroForNothingAndForAPureMoment) {
  EXPECT_EQ(glm::length(ComputeSeparationStep({}, 0.035).delta_x), 0.0);
  const SeparationStep step = ComputeSeparationStep({glm::dvec3(0), glm::dvec3(0, 0, 1e-4)}, 0.035);
  EXPECT_EQ(glm::length(step.delta_x) + glm::length(step.delta_phi_per_m), 0.0);
}

constexpr double kRest_m = 2.5e-4;

struct CouplingResult {
  core::Pose X_WC;
  core::Wrench F_Do_W;
};

CouplingResult Stepped(VirtualCoupling& coupling, const core::Pose& X_WD, const CouplingContact& contact) {
  const core::Wrench F_Do_W = coupling.Step(X_WD, contact);
  return {coupling.X_WC(), F_Do_W};
}

// A ball of 10 mm at the hand's origin against analytic half-spaces n . x >= 0.
struct AnalyticScene {
  std::vector<glm::dvec3> normals;
  double radius_m = 0.01;
  double look_ahead_m = 0.002;

  CouplingResult Step(VirtualCoupling& coupling, const core::Pose& X_WD) const {
    CouplingContact contact;
    for (const glm::dvec3& n : normals) {
      const double gap_m = glm::dot(n, coupling.X_WC().translation) - radius_m;
      if (gap_m > look_ahead_m) {
        contact.free_distance_m = std::min(contact.free_distance_m, gap_m + kRest_m);
        continue;
      }
      contact.planes.push_back({-radius_m * n, n, gap_m, kRest_m});
      if (gap_m > 0.0) continue;
      contact.is_in_contact = true;
      contact.deepest_excess_m = std::max(contact.deepest_excess_m, -gap_m - kRest_m);
      contact.f_Co_W += {-gap_m * n, glm::cross(-radius_m * n, -gap_m * n)};
    }
    return Stepped(coupling, X_WD, contact);
  }
};

TEST(VirtualCoupling, PressedOnAPlaneGivesStiffnessTimesDepth) {
  const AnalyticScene scene{{{0, 0, 1}}};
  VirtualCoupling coupling;
  coupling.Reset(At(0, 0, 0.05));
  CouplingResult result;
  double z = 0.05;
  for (int i = 0; i < 600; ++i) {
    z = std::max(z - 1e-4, 0.005);  // 0.1 m/s down to 5 mm below touch
    result = scene.Step(coupling, At(0, 0, z));
  }
  const double depth_m = 0.005 - kRest_m;
  EXPECT_NEAR(result.F_Do_W.force_N.z, 2500 * depth_m, 1e-6);
  EXPECT_NEAR(result.X_WC.translation.z, 0.01 - kRest_m, 1e-9);
  double previous = result.F_Do_W.force_N.z;
  for (int i = 0; i < 100; ++i) {  // and does not chatter
    result = scene.Step(coupling, At(0, 0, z));
    EXPECT_NEAR(result.F_Do_W.force_N.z, previous, 1e-9);
  }
}

TEST(VirtualCoupling, SlidesWithTheDevice) {
  const AnalyticScene scene{{{0, 0, 1}}};
  VirtualCoupling coupling;
  coupling.Reset(At(0, 0, 0.011));
  for (int i = 0; i < 1000; ++i) {
    const CouplingResult result = scene.Step(coupling, At(1e-4 * i, 0, 0.006));
    EXPECT_NEAR(result.F_Do_W.force_N.x, 0.0, 1e-9);
  }
}

TEST(VirtualCoupling, LettingGoLeavesNoForce) {
  const AnalyticScene scene{{{0, 0, 1}}};
  VirtualCoupling coupling;
  coupling.Reset(At(0, 0, 0.011));
  for (int i = 0; i < 100; ++i) scene.Step(coupling, At(0, 0, 0.005));
  CouplingResult result;
  for (int i = 0; i < 100; ++i) result = scene.Step(coupling, At(0, 0, 0.02));
  EXPECT_EQ(glm::length(result.F_Do_W.force_N), 0.0);
}

TEST(VirtualCoupling, StaysInACorner) {
  const AnalyticScene scene{{{0, 0, 1}, glm::normalize(glm::dvec3(1, 0, 0.2)), {0, 1, 0}}};
  VirtualCoupling coupling;
  coupling.Reset(At(0.03, 0.03, 0.03));
  CouplingResult result;
  for (int i = 0; i < 800; ++i) result = scene.Step(coupling, At(-0.02, -0.01, -0.005));
  for (const glm::dvec3& n : scene.normals) {
    EXPECT_NEAR(glm::dot(n, result.X_WC.translation), 0.01 - kRest_m, 1e-4);
  }
  const CouplingResult next = scene.Step(coupling, At(-0.02, -0.01, -0.005));
  EXPECT_LT(glm::length(next.F_Do_W.force_N - result.F_Do_W.force_N), 1e-3);
}

TEST(VirtualCoupling, RestsInEachPlaneAsDeepAsThatPlaneSays) {
  VirtualCoupling coupling;
  coupling.Reset(At(0.011, 0, 0.011));
  for (int i = 0; i < 400; ++i) {
    const glm::dvec3 gap_m = coupling.X_WC().translation - 0.01;
    CouplingContact contact;
    contact.planes.push_back({{-0.01, 0, 0}, {1, 0, 0}, gap_m.x, 2e-4});
    contact.planes.push_back({{0, 0, -0.01}, {0, 0, 1}, gap_m.z, 1.5e-3});
    contact.free_distance_m = 0.002;
    coupling.Step(At(0.005, 0, 0.005), contact);
  }
  EXPECT_NEAR(coupling.X_WC().translation.x, 0.01 - 2e-4, 1e-9);
  EXPECT_NEAR(coupling.X_WC().translation.z, 0.01 - 1.5e-3, 1e-9);
}

TEST(VirtualCoupling, ASlotHoldsWithoutNoise) {  // two planes that face each other, 0.2 mm of play
  VirtualCoupling coupling;
  coupling.Reset(At(0.0101, 0, 0));
  double previous_N = 0.0;
  for (int i = 0; i < 400; ++i) {
    const double x = coupling.X_WC().translation.x;
    CouplingContact contact;
    contact.planes.push_back({{-0.01, 0, 0}, {1, 0, 0}, x - 0.01, kRest_m});
    contact.planes.push_back({{0.01, 0, 0}, {-1, 0, 0}, 0.0102 - x, kRest_m});
    contact.free_distance_m = 0.002 + kRest_m;
    const double depth_m = std::max(0.01 - x, x - 0.0102);
    contact.deepest_excess_m = depth_m - kRest_m;
    contact.is_in_contact = depth_m >= 0.0;
    if (x < 0.01) contact.f_Co_W += {{0.01 - x, 0, 0}, {}};
    if (x > 0.0102) contact.f_Co_W += {{0.0102 - x, 0, 0}, {}};
    const double force_N = Stepped(coupling, At(0.013, 0, 0), contact).F_Do_W.force_N.x;
    if (i > 200) {
      EXPECT_NEAR(force_N, previous_N, 1e-6);
    }
    previous_N = force_N;
  }
  EXPECT_NEAR(previous_N, -2500 * (0.013 - 0.0102 - kRest_m), 1e-3);
}

TEST(VirtualCoupling, NeverTunnelsAtTwoMetresPerSecond) {
  const AnalyticScene scene{{{0, 0, 1}}};
  VirtualCoupling coupling;
  coupling.Reset(At(0, 0, 0.2));
  for (int i = 0; i < 300; ++i) {
    const CouplingResult result = scene.Step(coupling, At(0, 0, 0.2 - 2e-3 * i));
    EXPECT_GT(result.X_WC.translation.z, 0.01 - 2.1 * kRest_m) << i;
  }
}

TEST(CouplingWrench, IsFrameInvariant) {
  const core::Pose X_WD{core::QuaternionFromRotationVector({0.1, 0.7, -0.3}), {0.1, 0.2, 0.3}};
  const core::Pose X_WC =
      X_WD * core::Pose{core::QuaternionFromRotationVector({0.02, -0.01, 0.03}), {1e-3, -2e-3, 5e-4}};
  const core::Pose X_UW{core::QuaternionFromRotationVector({-0.5, 0.2, 1.0}), {3, -1, 2}};
  const core::Wrench F_W = CouplingWrench({}, X_WD, X_WC);
  const core::Wrench F_U = CouplingWrench({}, X_UW * X_WD, X_UW * X_WC);
  EXPECT_LT(glm::length(X_UW.rotate(F_W.force_N) - F_U.force_N), 1e-9);
  EXPECT_LT(glm::length(X_UW.rotate(F_W.torque_Nm) - F_U.torque_Nm), 1e-9);
}

}  // namespace
}  // namespace vps
