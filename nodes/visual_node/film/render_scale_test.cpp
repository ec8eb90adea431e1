#include "nodes/visual_node/film/render_scale.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace visual_node {
namespace {

constexpr double kBudget_s = 0.030;

// A machine on which a picture takes fixed_s, and full_s more at full scale.
struct Machine {
  double fixed_s;
  double full_s;
  [[nodiscard]] double Picture_s(double scale) const { return fixed_s + full_s * scale * scale; }
};

TEST(RenderScale, HoldsTheTimeOfAPictureOnAnyMachineThatCan) {
  for (const Machine machine : {Machine{0.002, 0.020}, {0.005, 0.050}, {0.002, 0.120}, {0.018, 0.060}, {0.0, 0.3}}) {
    RenderScale scale(kBudget_s);
    for (int i = 0; i < 400; ++i) scale.Update(machine.Picture_s(scale.value()));
    EXPECT_LE(machine.Picture_s(scale.value()), kBudget_s);
    // Nothing is given away: two steps more would be too slow.
    const double larger = scale.value() + 2.0 * RenderScale::kStep;
    EXPECT_TRUE(larger > 1.0 || machine.Picture_s(larger) > RenderScale::kReserve * kBudget_s) << scale.value();
  }
}

TEST(RenderScale, ComesToRest) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(0.95, 1.05);
  for (double full_s = 0.01; full_s < 0.25; full_s *= 1.07) {
    const Machine machine{0.004, full_s};
    RenderScale scale(kBudget_s);
    for (int i = 0; i < 400; ++i) scale.Update(noise(random) * machine.Picture_s(scale.value()));
    int changes = 0;  // noise may still take it over one threshold, but never back
    for (int i = 0; i < 2000; ++i) {
      const double before = scale.value();
      scale.Update(noise(random) * machine.Picture_s(scale.value()));
      changes += scale.value() != before;
    }
    EXPECT_LE(changes, 1) << full_s;
  }
}

TEST(RenderScale, ChangesNothingForSingleSlowPictures) {
  RenderScale scale(kBudget_s);
  for (int i = 0; i < 500; ++i) {
    scale.Update(i % 5 == 0 ? 0.4 : 0.02);
    EXPECT_EQ(scale.value(), 1.0);
  }
}

TEST(RenderScale, ReturnsToFullScaleWhenTheLoadIsGone) {
  RenderScale scale(kBudget_s);
  for (int i = 0; i < 100; ++i) scale.Update(0.1);
  EXPECT_NEAR(scale.value(), RenderScale::kLeast, 1e-9);
  const Machine fast{0.002, 0.01};
  for (int i = 0; i < 400; ++i) scale.Update(fast.Picture_s(scale.value()));
  EXPECT_EQ(scale.value(), 1.0);
}

TEST(RenderScale, IsHalvedWithinThirtyPicturesWhenTheyTakeFourTimesTheirTime) {
  RenderScale scale(kBudget_s);
  const Machine slow{0.0, 4.0 * kBudget_s};
  for (int i = 0; i < 30; ++i) scale.Update(slow.Picture_s(scale.value()));
  EXPECT_LE(slow.Picture_s(scale.value()), kBudget_s);
  EXPECT_GE(scale.value(), 0.45);
}

TEST(RenderScale, FromTheLeastIsAtFullScaleSoonOnAFastMachine) {
  RenderScale scale = RenderScale::FromLeast(kBudget_s);
  EXPECT_NEAR(scale.value(), RenderScale::kLeast, 1e-9);
  const Machine fast{0.002, 0.02};
  for (int i = 0; i < 30; ++i) scale.Update(fast.Picture_s(scale.value()));
  EXPECT_EQ(scale.value(), 1.0);
}

}  // namespace
}  // namespace visual_node
