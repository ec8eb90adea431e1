#include "view/step_goals.hpp"

#include <gtest/gtest.h>

#include "core/messages/logic.hpp"
#include "scene/load_scenario.hpp"
#include "view/scene_mirror.hpp"

namespace view {
namespace {

class StepGoals : public testing::Test {
 protected:
  // The scene of a step with planned ways.
  Scene SceneOf(const std::string& step) {
    SceneMirror mirror(scenario_);
    Choices choices;
    choices.overlays.reset();
    choices.overlays[IndexOf(Overlay::kPlanned)] = true;
    mirror.Choose(choices);
    core::LogicStatus status;
    status.step = step;
    mirror.Apply(status);
    mirror.Refresh(0);
    return mirror.scene();
  }
  const scene::Scenario scenario_ = *scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/module_replacement");
};

TEST_F(StepGoals, AWayLeadsAPartAlongTheSocketsAxisToItsSeat) {
  const Scene scene = SceneOf("insert_handle");
  const scene::Mechanism& hook = scenario_.mechanisms[static_cast<std::size_t>(scenario_.FindMechanism("hook_old"))];
  const core::Pose X_WSeat = scene.instances[static_cast<std::size_t>(hook.parent)].X_WM * hook.X_PJ;
  ASSERT_EQ(scene.lines.size(), 1u);
  const std::vector<glm::vec3>& way = *scene.lines[0].p_W;
  ASSERT_EQ(way.size(), 3u);
  EXPECT_LT(glm::distance(glm::dvec3(way[2]), X_WSeat.translation), 1e-6);
  const glm::dvec3 last = glm::normalize(glm::dvec3(way[1] - way[2]));
  EXPECT_NEAR(glm::dot(last, X_WSeat.rotate({0.0, 0.0, 1.0})), 1.0, 1e-5);
  ASSERT_EQ(scene.phantoms.size(), 1u);
  const core::Pose X_WPlug = scene.phantoms[0].X_WM * hook.X_CJ;
  EXPECT_EQ(scene.phantoms[0].instance, static_cast<std::uint32_t>(hook.child));
  EXPECT_LT(glm::distance(X_WPlug.translation, X_WSeat.translation), 1e-9);
}

TEST_F(StepGoals, AWayLeadsTheHandToWhatItIsToHold) {
  const Scene scene = SceneOf("grasp");
  ASSERT_EQ(scene.lines.size(), 1u);
  const auto handle = static_cast<std::size_t>(scenario_.FindObject("handle"));
  EXPECT_LT(glm::distance(glm::dvec3(scene.lines[0].p_W->back()), scene.instances[handle].X_WM.translation), 1e-6);
}

TEST_F(StepGoals, AStepOfASwitchHasNoWay) {
  EXPECT_TRUE(SceneOf("switch_on").lines.empty());
  EXPECT_TRUE(SceneOf("no_such_step").lines.empty());
}

}  // namespace
}  // namespace view
