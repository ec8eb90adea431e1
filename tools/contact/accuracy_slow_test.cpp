#include <gtest/gtest.h>

#include "tools/contact/testing/published_wrenches.hpp"

namespace contact {
namespace {

TEST(SlowPublishedAccuracy, HoldsForTwoBunniesInLightContact) {
  ExpectPublishedWrenches("bunnies", "bunny_light");
}

TEST(SlowPublishedAccuracy, HoldsForTwoBunniesDeepInEachOther) {
  ExpectPublishedWrenches("bunnies", "bunny_deep");
}

}  // namespace
}  // namespace contact
