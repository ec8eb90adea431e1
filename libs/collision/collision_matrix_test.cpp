#include "collision/collision_matrix.hpp"

#include <gtest/gtest.h>

namespace collision {
namespace {

core::Collision Between(std::uint16_t sampled, std::uint16_t field, float depth_m) {
  core::Collision collision;
  collision.sampled_body = sampled;
  collision.field_body = field;
  collision.depth_m = depth_m;
  return collision;
}

TEST(CollisionMatrix, AnswersInEitherOrderWithTheDeepestPair) {
  core::CollisionMatrix matrix;
  AddCollision(Between(1, 2, 0.001f), &matrix);
  AddCollision(Between(2, 1, 0.003f), &matrix);
  AddCollision(Between(1, 3, 0.002f), &matrix);
  ASSERT_TRUE(AreColliding(matrix, 2, 1));
  EXPECT_EQ(FindCollision(matrix, 1, 2)->depth_m, 0.003f);
  EXPECT_TRUE(AreColliding(matrix, 3, 1));
  EXPECT_FALSE(AreColliding(matrix, 2, 3));
}

TEST(CollisionMatrix, KeepsTheDeepestAndCountsTheRest) {
  core::CollisionMatrix matrix;
  for (std::uint16_t i = 0; i < core::kMaxCollisions; ++i) AddCollision(Between(0, i, 0.001f * (1 + i)), &matrix);
  AddCollision(Between(0, 1000, 0.01f), &matrix);
  AddCollision(Between(0, 1001, 0.0001f), &matrix);
  EXPECT_EQ(matrix.num_touching, core::kMaxCollisions + 2);
  EXPECT_TRUE(AreColliding(matrix, 0, 1000));
  EXPECT_FALSE(AreColliding(matrix, 0, 1001)) << "shallower than all that are listed";
  EXPECT_FALSE(AreColliding(matrix, 0, 0)) << "was the shallowest";
  EXPECT_TRUE(AreColliding(matrix, 0, 1));
}

}  // namespace
}  // namespace collision
