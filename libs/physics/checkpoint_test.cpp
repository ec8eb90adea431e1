#include "physics/checkpoint.hpp"

#include <gtest/gtest.h>

#include "physics/testing/trials/busy.hpp"

namespace physics {
namespace {

using trials::Busy;

TEST(Checkpoint, RestoredRunContinuesBitForBit) {
  EXPECT_EQ(trials::StepsThatDifferAfterRestore(700), 0);
}

TEST(Checkpoint, ImpulseBalanceContinuesBitForBit) {
  Busy whole;
  whole.Run(333);
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  Busy restored;
  ASSERT_TRUE(restored.world.Restore(&checkpoint).has_value());
  whole.Run(100);
  restored.Run(100);
  EXPECT_EQ(restored.world.impulse_balance().linear_magnitude_Ns, whole.world.impulse_balance().linear_magnitude_Ns);
}

TEST(Checkpoint, PosesAndVelocitiesAloneAreNotEnough) {
  // A checkpoint also holds the impulses of the last step (warm start): without them the next step differs.
  Busy whole;
  whole.Run(333);
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  Busy restored;
  ASSERT_TRUE(restored.world.Restore(&checkpoint).has_value());
  restored.world.ClearContact(restored.pair);
  restored.world.SetContactPlanes(restored.pair, Busy::Feet(0.0));
  whole.Run(50);
  restored.Run(50);
  EXPECT_NE(restored.world.StateHash(), whole.world.StateHash());
}

TEST(Checkpoint, RefusesACheckpointOfAnotherWorld) {
  Busy whole;
  Checkpoint checkpoint;
  whole.world.Save(&checkpoint);
  World other;
  const auto restored = other.Restore(&checkpoint);
  ASSERT_FALSE(restored.has_value());
  EXPECT_NE(restored.error().detail.find("another world"), std::string::npos);
}

}  // namespace
}  // namespace physics
