#include "view/tactile_marks.hpp"

#include <gtest/gtest.h>

namespace view {
namespace {

core::TactileState SixMotors() {
  core::TactileState state;
  state.status = 1;
  state.channels.resize(6);
  state.channels[1].level = 0.5f;
  return state;
}

TEST(TactileMarks, TheMotorThatRunsIsBrightAndWhereItIs) {
  scene::Tactile tactile;
  tactile.X_OB.translation = {0.0, 0.0, 0.1};
  core::Pose X_WO;
  X_WO.translation = {1.0, 0.0, 0.0};
  Scene scene;
  AddTactileRing(SixMotors(), tactile, X_WO, &scene);
  ASSERT_EQ(scene.points.size(), 1u);
  const PointSet& ring = scene.points[0];
  EXPECT_EQ(ring.X_WP.translation, glm::dvec3(1.0, 0.0, 0.1));
  ASSERT_EQ(ring.p_P->size(), 6u);
  // Motor 1 is 60 degrees from x towards y.
  EXPECT_NEAR(std::atan2((*ring.p_P)[1].y, (*ring.p_P)[1].x), 1.0472, 1e-4);
  for (const std::size_t i : {0u, 2u, 3u, 4u, 5u}) EXPECT_LT((*ring.colors)[i].r, (*ring.colors)[1].r) << i;
}

TEST(TactileMarks, TheLineSaysThatADeviceIsSimulatedHowStrongItIsAndWhatIsWrong) {
  scene::Tactile tactile;
  tactile.name = "bracelet";
  core::TactileState state = SixMotors();
  EXPECT_EQ(TactileLine(state, tactile).text, "bracelet (SIMULATED)  50 %");
  state.pattern = 3;
  EXPECT_EQ(TactileLine(state, tactile).text, "bracelet (SIMULATED)  50 %  slip");
  state.stopped_by = 2;
  EXPECT_EQ(TactileLine(state, tactile).text, "bracelet (SIMULATED)  stopped, open electrode");
  state.is_simulated = false;
  state.status = 3;
  EXPECT_EQ(TactileLine(state, tactile).text, "bracelet  is gone");
  EXPECT_NE(TactileLine(state, tactile).color, TactileLine(SixMotors(), tactile).color);
}

}  // namespace
}  // namespace view
