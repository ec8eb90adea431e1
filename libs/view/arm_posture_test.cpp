#include "view/arm_posture.hpp"

#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>
#include <random>

#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace view {
namespace {

scene::Scenario ModuleReplacement() {
  auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "module_replacement");
  EXPECT_TRUE(scenario);
  return scenario ? *scenario : scene::Scenario{};
}

core::Pose Anywhere(std::mt19937* random, double reach_m) {
  std::normal_distribution<double> normal;
  const auto next = [&] { return normal(*random); };
  const double w = next(), x = next(), y = next(), z = next();
  const glm::dvec3 direction(next(), next(), next());
  const double length_m = reach_m * std::cbrt(std::uniform_real_distribution<double>(0.0, 1.0)(*random));
  return {glm::normalize(glm::dquat(w, x, y, z)), length_m * glm::normalize(direction)};
}

// With a shoulder at z = 0.23 m of the mount, two links of 0.4 m and a wrist of 0.1 m.
TEST(ArmPosture, ItsFlangeIsWhereItIsWantedWheneverItReaches) {
  const scene::ShownArm arm = ModuleReplacement().shown_arms.at(0);
  const ArmPosture posture(arm);
  std::mt19937 random(1);
  int num_reached = 0;
  for (int i = 0; i < 20000; ++i) {
    const core::Pose X_WF = arm.X_WB * Anywhere(&random, 1.4);
    const ArmPosture::Links links = posture.At(X_WF);
    if (!links.is_reached) continue;
    ++num_reached;
    ASSERT_LT(glm::distance(links.X_WF.translation, X_WF.translation), 1e-6);
    ASSERT_GT(std::abs(glm::dot(links.X_WF.rotation, X_WF.rotation)), 1.0 - 1e-12);
  }
  EXPECT_GT(num_reached, 3000);
}

TEST(ArmPosture, ItsLinksHangTogether) {
  const scene::ShownArm arm = ModuleReplacement().shown_arms.at(0);
  const ArmPosture posture(arm);
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const ArmPosture::Links links = posture.At(arm.X_WB * Anywhere(&random, 2.0));  // also out of reach
    core::Pose X_WP = arm.X_WB;
    for (std::size_t k = 0; k < ArmPosture::kNumJoints; ++k) {
      const core::Pose X_JL = (X_WP * arm.links[k].X_PJ).inverse() * links.X_WL[k];
      ASSERT_LT(glm::length(X_JL.translation), 1e-9) << k;
      ASSERT_LT(std::abs(X_JL.rotation.x) + std::abs(X_JL.rotation.y), 1e-9) << k << ": not about z";
      X_WP = links.X_WL[k];
    }
  }
}

TEST(ArmPosture, StretchesTowardsWhatIsOutOfReach) {
  const scene::ShownArm arm = ModuleReplacement().shown_arms.at(0);
  const ArmPosture posture(arm);
  const core::Pose X_WF = arm.X_WB * core::Pose{{1.0, 0.0, 0.0, 0.0}, {0.3, -0.4, 3.0}};
  const ArmPosture::Links links = posture.At(X_WF);
  EXPECT_FALSE(links.is_reached);
  const glm::dvec3 shoulder = links.X_WL[1].translation, elbow = links.X_WL[3].translation,
                   wrist = links.X_WL[5].translation;
  EXPECT_NEAR(glm::distance(shoulder, wrist), glm::distance(shoulder, elbow) + glm::distance(elbow, wrist), 1e-9);
  EXPECT_GT(std::abs(glm::dot(links.X_WF.rotation, X_WF.rotation)), 1.0 - 1e-12);
}

TEST(ArmPosture, MovesALittleWhenTheHandMovesALittle) {
  const scene::ShownArm arm = ModuleReplacement().shown_arms.at(0);
  const ArmPosture posture(arm);
  // As the scenario's hand goes: fingers down, 1 mm between two poses.
  core::Pose X_WF{core::QuaternionFromRollPitchYaw({glm::pi<double>(), 0.0, 0.0}), {-0.22, -0.12, 0.35}};
  ArmPosture::Links before = posture.At(X_WF);
  for (int i = 0; i < 560; ++i) {
    X_WF.translation += glm::dvec3(1e-3, 0.5e-3, (i < 200 ? -0.3e-3 : 0.2e-3));
    const ArmPosture::Links now = posture.At(X_WF);
    ASSERT_TRUE(now.is_reached) << i;
    for (std::size_t k = 0; k < ArmPosture::kNumJoints; ++k) {
      ASSERT_LT(glm::distance(now.X_WL[k].translation, before.X_WL[k].translation), 5e-3) << k;
      ASSERT_GT(std::abs(glm::dot(now.X_WL[k].rotation, before.X_WL[k].rotation)), std::cos(0.03)) << k;
    }
    before = now;
  }
}

TEST(ArmPosture, TheArmOfASceneHoldsItsGripper) {
  const scene::Scenario scenario = ModuleReplacement();
  SceneMirror mirror(scenario);
  const scene::ShownArm& arm = scenario.shown_arms.at(0);
  const std::size_t last = mirror.scene().instances.size() - 1;
  const auto palm = static_cast<std::size_t>(scenario.devices.at(0).palm);
  // Where the operator takes the hand.
  for (const glm::dvec3& p :
       {glm::dvec3(0.13, -0.12, 0.3), glm::dvec3(0.34, 0.19, 0.18), glm::dvec3(0.107, 0.06, 0.03),
        glm::dvec3(0.26, -0.12, 0.1), glm::dvec3(-0.22, 0.12, 0.33), glm::dvec3(-0.22, -0.12, 0.33)}) {
    core::HapticProxy proxy;
    proxy.X_WD = proxy.X_WC = {core::QuaternionFromRollPitchYaw({0.02, -0.03, 0.05}), p};
    mirror.Apply(proxy);
    mirror.Refresh(0);
    const Scene& scene = mirror.scene();
    const core::Pose X_WF = scene.instances[last].X_WM * arm.X_7F;
    const core::Pose wanted = scene.instances[palm].X_WM * arm.X_PalmF;
    EXPECT_LT(glm::distance(X_WF.translation, wanted.translation), 1e-6);
    EXPECT_GT(std::abs(glm::dot(X_WF.rotation, wanted.rotation)), 1.0 - 1e-12);
    EXPECT_TRUE(scene.instances[last].is_scenery);
  }
}

}  // namespace
}  // namespace view
