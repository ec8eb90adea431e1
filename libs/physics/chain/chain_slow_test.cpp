// The articulated-body algorithm against MuJoCo, where that is installed (VR_OOS_PEERS); the planar arm's closed form
// is the reference in the fast tests.
#ifdef VR_OOS_HAS_MUJOCO

#include <gtest/gtest.h>

#include "physics/testing/mujoco_arm.hpp"

namespace physics {
namespace {

TEST(ChainAgainstMuJoCo, JointAccelerationsAtAThousandRandomStates) {
  const double worst = test::WorstArmError();
  RecordProperty("worst_relative", std::to_string(worst * 1e12) + "e-12");
  EXPECT_LE(worst, 1e-8);
}

}  // namespace
}  // namespace physics

#endif
