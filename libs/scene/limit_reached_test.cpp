#include "scene/limit_reached.hpp"

#include <gtest/gtest.h>

namespace scene {
namespace {

TEST(LimitReached, SaysPartsOfASecond) {
  EXPECT_EQ(LimitReached(0.25, "approach"), "limit of 0.25 s reached in step 'approach'");
  EXPECT_EQ(LimitReached(3600.0, "approach"), "limit of 3600 s reached in step 'approach'");
}

}  // namespace
}  // namespace scene
