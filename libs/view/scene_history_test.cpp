#include "view/scene_history.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace view {
namespace {

Scene SceneAt(double x_m, double time_s, const std::string& step = "") {
  Scene scene;
  scene.instances.resize(2);
  scene.instances[1].X_WM.translation.x = x_m;
  scene.time_ns = static_cast<std::int64_t>(time_s * 1e9);
  scene.step = step;
  return scene;
}

TEST(SceneHistory, APathHasOnlyThingsThatMoveAndNoPointTwice) {
  SceneHistory history({false, true});
  for (int k = 1; k <= 40; ++k)
    history.Take(SceneAt(k <= 20 ? 0.01 * k : 0.2, 0.1 * k), k * core::kNanosecondsPerSecond);
  Scene scene;
  history.AddPaths(&scene);
  ASSERT_EQ(scene.lines.size(), 1u);
  EXPECT_EQ(scene.lines[0].p_W->size(), 20u);
  EXPECT_EQ(scene.lines[0].p_W->front().x, 0.01f);
  EXPECT_EQ(scene.lines[0].p_W->back().x, 0.2f);
}

TEST(SceneHistory, APathForgetsItsBeginning) {
  SceneHistory history({false, true});
  for (std::size_t k = 1; k <= SceneHistory::kMaxPathPoints + 10; ++k) {
    const auto i = static_cast<std::int64_t>(k);
    history.Take(SceneAt(0.01 * static_cast<double>(k), static_cast<double>(k)), i * core::kNanosecondsPerSecond);
  }
  Scene scene;
  history.AddPaths(&scene);
  EXPECT_EQ(scene.lines[0].p_W->size(), SceneHistory::kMaxPathPoints);
  EXPECT_FLOAT_EQ(scene.lines[0].p_W->front().x, 0.11f);
}

TEST(SceneHistory, StepsHaveTheirSimulatedTimes) {
  SceneHistory history({});
  history.Take(SceneAt(0, 1.0, "cover"), 0);
  history.Take(SceneAt(0, 4.5, "grasp"), core::kNanosecondsPerSecond);
  Scene scene = SceneAt(0, 6.0, "grasp");
  history.AddSteps(&scene);
  ASSERT_EQ(scene.texts.size(), 2u);
  EXPECT_EQ(scene.texts[0].text, "cover   3.5 s");
  EXPECT_EQ(scene.texts[1].text, "grasp   1.5 s ...");
}

TEST(SceneHistory, TheClockComparesSimulatedAndRealTime) {
  SceneHistory history({});
  for (int k = 0; k <= 40; ++k) history.Take(SceneAt(0, 1.0 + 0.05 * k), k * core::kNanosecondsPerSecond / 10);
  Scene scene;
  history.AddClock(&scene);
  ASSERT_EQ(scene.texts.size(), 1u);
  EXPECT_EQ(scene.texts[0].text, "simulated 2.0 s in 4.0 s, now at 0.50 of real time");
}

TEST(SceneHistory, ARestartedPhysicsBeginsAnew) {
  SceneHistory history({false, true});
  history.Take(SceneAt(0.1, 5.0, "cover"), core::kNanosecondsPerSecond);
  history.Take(SceneAt(0.2, 6.0, "cover"), 2 * core::kNanosecondsPerSecond);
  history.Take(SceneAt(0.0, 0.1, "cover"), 3 * core::kNanosecondsPerSecond);
  Scene scene;
  history.AddPaths(&scene);
  EXPECT_TRUE(scene.lines.empty());
}

TEST(SceneHistory, ACountsCourseIsWhatWasAdded) {
  SceneHistory history({});
  for (const double count : {10.0, 10.0, 13.0}) history.TakeCount(SceneHistory::Course::kLateCycles, count);
  history.TakeFigure(SceneHistory::Course::kT1, 0.75);
  Scene scene;
  history.AddGraphs(&scene);
  ASSERT_EQ(scene.graphs.size(), 2u);
  EXPECT_EQ(scene.graphs[0].values.size(), SceneHistory::kCourseLength);
  EXPECT_EQ(scene.graphs[0].values.back(), 0.75f);
  EXPECT_EQ(scene.graphs[1].values.back(), 3.0f);
  EXPECT_EQ(scene.graphs[1].values[SceneHistory::kCourseLength - 2], 0.0f);
}

}  // namespace
}  // namespace view
