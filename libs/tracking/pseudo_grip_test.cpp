#include "tracking/pseudo_grip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

namespace tracking {
namespace {

constexpr double kOpen_m = 0.08, kMost_N = 40.0, kDt_s = 1e-3;

TEST(PseudoGrip, AStickOpensClosesAndPresses) {
  EXPECT_EQ(WishOfStick(1.0, kOpen_m, kMost_N).opening_m, kOpen_m);
  EXPECT_EQ(WishOfStick(1.0, kOpen_m, kMost_N).force_N, 0.0);
  EXPECT_EQ(WishOfStick(0.0, kOpen_m, kMost_N).opening_m, 0.0);
  EXPECT_EQ(WishOfStick(0.0, kOpen_m, kMost_N).force_N, 0.0);
  EXPECT_EQ(WishOfStick(-1.0, kOpen_m, kMost_N).force_N, kMost_N);
  EXPECT_EQ(WishOfStick(-1.0, kOpen_m, kMost_N).opening_m, 0.0);
  EXPECT_EQ(WishOfStick(-7.0, kOpen_m, kMost_N).force_N, kMost_N);
}

TEST(PseudoGrip, EachMethodIsLinearInWhatThePersonDoesUpToItsMost) {
  for (int i = 0; i <= 100; ++i) {
    const double u = 0.01 * i;
    EXPECT_NEAR(WishOfStick(-u, kOpen_m, kMost_N).force_N, u * kMost_N, 1e-12);
    EXPECT_NEAR(WishOfStick(u, kOpen_m, kMost_N).opening_m, u * kOpen_m, 1e-15);
    EXPECT_NEAR(WishOfPinch(u, 0.02, kOpen_m, kMost_N).force_N, u * kMost_N, 1e-12);
    EXPECT_NEAR(WishOfDistance(0.03 - 0.02 * u, 0.03, kOpen_m, 3000.0, kMost_N).force_N, std::min(60.0 * u, kMost_N),
                1e-9);
  }
  EXPECT_EQ(WishOfDistance(0.05, 0.03, kOpen_m, 3000.0, kMost_N).force_N, 0.0);
  EXPECT_EQ(WishOfDistance(-0.05, 0.03, kOpen_m, 1000.0, kMost_N).force_N, 30.0) << "tips do not pass each other";
}

// Jaws on something that gives 8 kN/m; they hear of it some steps late.
class Bench {
 public:
  Bench(double opening_m, std::size_t delay) : jaws_(kOpen_m, opening_m), reactions_(delay, 0.0) {}

  // The ripple is that of the last tenth of the steps.
  void Press(const GripWish& wish, double width_m, int steps) {
    least_N_ = 1e9;
    most_N_ = 0.0;
    for (int i = 0; i < steps; ++i) {
      force_N_ = 8000.0 * std::max(0.0, width_m - jaws_.opening_m());
      highest_N_ = std::max(highest_N_, force_N_);
      if (i >= steps - std::max(1, steps / 10)) {
        least_N_ = std::min(least_N_, force_N_);
        most_N_ = std::max(most_N_, force_N_);
      }
      reactions_.push_back(force_N_);
      jaws_.Step(wish, reactions_.front(), kDt_s);
      reactions_.pop_front();
    }
  }
  [[nodiscard]] const PseudoJaws& jaws() const { return jaws_; }
  [[nodiscard]] double force_N() const { return force_N_; }
  [[nodiscard]] double highest_N() const { return highest_N_; }  // ever
  [[nodiscard]] double ripple_N() const { return most_N_ - least_N_; }

 private:
  PseudoJaws jaws_;
  std::deque<double> reactions_;
  double force_N_ = 0.0, highest_N_ = 0.0, least_N_ = 0.0, most_N_ = 0.0;
};

TEST(PseudoJaws, PressWithTheForceThatIsWishedWhateverIsBetweenThem) {
  for (const double width_m : {0.006, 0.016, 0.06}) {
    for (const double force_N : {0.5, 5.0, 40.0}) {
      Bench bench(kOpen_m, 3);
      bench.Press({0.0, force_N}, width_m, 2000);
      EXPECT_NEAR(bench.force_N(), force_N, 1e-6);
      // While the reaction is on its way, they go on at their speed.
      EXPECT_LT(bench.highest_N(), force_N + 8000.0 * PseudoJaws::kSpeed_m_per_s * 4.0 * kDt_s);
    }
  }
}

// The bound of the header, k T / b = pi / 2, is at 13 ms.
TEST(PseudoJaws, SettleUpToTheDelayOfTheirDerivationAndNotBeyond) {
  const auto RippleWithDelay_N = [](std::size_t delay) {
    Bench bench(0.03, delay);
    bench.Press({0.0, 10.0}, 0.03, 20000);
    return bench.ripple_N();
  };
  EXPECT_LT(RippleWithDelay_N(3), 1e-9);
  EXPECT_LT(RippleWithDelay_N(11), 1e-3);
  EXPECT_GT(RippleWithDelay_N(15), 1.0);
}

TEST(PseudoJaws, WithoutAForceTheyTouchAndDoNotPress) {
  Bench bench(kOpen_m, 3);
  bench.Press({0.0, 0.0}, 0.03, 3000);
  EXPECT_LT(bench.force_N(), PseudoJaws::kTouch_N);
  EXPECT_TRUE(bench.jaws().is_on_something());
  bench.Press({0.05, 0.0}, 0.03, 1000);
  EXPECT_NEAR(bench.jaws().opening_m(), 0.05, 1e-12);
  EXPECT_FALSE(bench.jaws().is_on_something());
}

TEST(PseudoJaws, CloseWhenWhatTheyHeldIsGone) {
  Bench bench(0.03, 3);
  bench.Press({0.0, 5.0}, 0.03, 1000);
  bench.Press({0.0, 5.0}, 0.0, 1000);
  EXPECT_EQ(bench.jaws().opening_m(), 0.0);
}

}  // namespace
}  // namespace tracking
