#include "tracking/tactile.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace tracking {
namespace {

TEST(Tactile, WritesOneBlockForEachFinger) {
  const std::array<FingerVibration, 2> fingers = {FingerVibration{0, 0, 0.5}, FingerVibration{1, 4, 1.0}};
  EXPECT_EQ(TactileDatagram(fingers), "tfb 2 [0 0 1.00 0.50] [1 4 1.00 1.00]");
  EXPECT_EQ(TactileDatagram({}), "tfb 0");
}

TEST(Tactile, StrengthIsNeverBeyondItsRange) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const auto& [strength, text] : {std::pair{1e300, "1.00"},
                                       {-1.0, "0.00"},
                                       {kInfinite, "0.00"},
                                       {std::numeric_limits<double>::quiet_NaN(), "0.00"}}) {
    const std::array<FingerVibration, 1> finger = {FingerVibration{0, 1, strength}};
    EXPECT_EQ(TactileDatagram(finger), std::string("tfb 1 [0 1 1.00 ") + text + "]");
  }
}

}  // namespace
}  // namespace tracking
