#include "nodes/device_bridge/operator/muscle_grip.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace device_bridge {
namespace {

scene::Device WithMuscle(const std::string& source) {
  scene::Device device;
  device.role = "right";
  device.options.emplace_back("muscle", source);
  return device;
}

TEST(MuscleGrip, IsAnOptionOfADevice) {
  const auto none = MuscleGrip::Create({}, 1);
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->has_value());
  EXPECT_FALSE(MuscleGrip::Create(WithMuscle("usb"), 1));
}

TEST(MuscleGrip, FollowsTheWantedStrengthWithinATenthOfTheStrongest) {
  auto made = MuscleGrip::Create(WithMuscle("simulated"), 1);
  ASSERT_TRUE(made);
  MuscleGrip& grip = **made;
  EXPECT_EQ(grip.Step(0.0), 0.0) << "it begins at rest";
  for (int i = 0; i < 40; ++i) EXPECT_LT(grip.Step(45.0), 20.0) << "what is wanted is not what is read at once";
  for (const double wanted_N : {20.0, 45.0, 0.0, 30.0}) {
    for (int i = 0; i < 500; ++i) grip.Step(wanted_N);
    for (int i = 0; i < 2000; ++i) EXPECT_NEAR(grip.Step(wanted_N), wanted_N, 0.1 * MuscleGrip::kStrongest_N);
  }
  EXPECT_EQ(grip.num_faults(), 0);
}

TEST(MuscleGrip, TheSameSeedGivesTheSameGrip) {
  auto one = MuscleGrip::Create(WithMuscle("simulated"), 5), same = MuscleGrip::Create(WithMuscle("simulated"), 5);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ((*one)->Step(30.0), (*same)->Step(30.0));
}

}  // namespace
}  // namespace device_bridge
