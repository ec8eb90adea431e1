#include "muscle/force_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "muscle/simulated_muscle.hpp"

namespace muscle {
namespace {

class EmgTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    EmgCalibrator calibrator;
    for (int i = 0; i < 3000; ++i) calibrator.Add(EmgCalibrator::Part::kRest, Envelopes(0.0));
    for (int i = 0; i < 3000; ++i) calibrator.Add(EmgCalibrator::Part::kMost, Envelopes(1.0));
    const auto calibration = calibrator.result();
    ASSERT_TRUE(calibration);
    estimate_.Calibrate(*calibration);
    for (int i = 0; i < 2000; ++i) Step(0.0);
  }
  EmgFrame Envelopes(double activation) {
    Step(activation);
    return estimate_.envelopes_V();
  }
  void Step(double activation) { estimate_.Step(muscle_.Step(activation)); }
  double share() const { return estimate_.share().value_or(-1.0); }

  SimulatedMuscle muscle_{7};
  ForceEstimate estimate_;
};

// Against the transfer function, written as the analogue filter with its frequency warped.
TEST(Biquad, HasButterworthsGainAtEveryFrequency) {
  for (const double corner_Hz : {2.5, 20.0, 450.0}) {
    for (const double f_Hz : {1.0, 10.0, 20.0, 100.0, 300.0, 450.0}) {
      const double ratio =
          std::tan(glm::pi<double>() * f_Hz * kSample_s) / std::tan(glm::pi<double>() * corner_Hz * kSample_s);
      const double low = 1.0 / std::sqrt(1.0 + std::pow(ratio, 4.0));
      Biquad low_pass = Biquad::LowPass(corner_Hz, kSample_s), high_pass = Biquad::HighPass(corner_Hz, kSample_s);
      std::complex<double> low_sum, high_sum;
      constexpr int kSettled = 5000, kSamples = 10000;  // whole periods of every frequency here
      for (int i = 0; i < kSettled + kSamples; ++i) {
        const double phase = glm::two_pi<double>() * f_Hz * kSample_s * i;
        const double low_y = low_pass.Step(std::cos(phase)), high_y = high_pass.Step(std::cos(phase));
        if (i < kSettled) continue;
        low_sum += low_y * std::polar(2.0 / kSamples, -phase);
        high_sum += high_y * std::polar(2.0 / kSamples, -phase);
      }
      EXPECT_NEAR(std::abs(low_sum), low, 1e-6) << corner_Hz << " " << f_Hz;
      EXPECT_NEAR(std::abs(high_sum), low * ratio * ratio, 1e-6) << corner_Hz << " " << f_Hz;
    }
  }
}

TEST_F(EmgTest, EstimatesTheActivationWithinATenth) {
  for (const double truth : {0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 0.3, 0.0}) {
    for (int i = 0; i < 600; ++i) Step(truth);
    double worst = 0.0;
    for (int i = 0; i < 10'000; ++i) {
      Step(truth);
      worst = std::max(worst, std::abs(share() - truth));
    }
    EXPECT_LE(worst, 0.1) << truth;
  }
}

// As people grip: up and down within a second or two. The truth is that of so long before.
TEST_F(EmgTest, FollowsAGripWithinATenthAndADelayOf150ms) {
  constexpr int kDelay = 100;
  std::vector<double> truths;
  double worst = 0.0, sum = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    truths.push_back(0.4 - 0.4 * std::cos(glm::two_pi<double>() * 0.3 * kSample_s * i));
    Step(truths.back());
    if (i < 1000) continue;
    worst = std::max(worst, std::abs(share() - truths[static_cast<std::size_t>(i - kDelay)]));
    sum += std::pow(share() - truths[static_cast<std::size_t>(i - kDelay)], 2);
  }
  EXPECT_LE(worst, 0.1);
  EXPECT_LE(std::sqrt(sum / 59'000.0), 0.04);
}

TEST_F(EmgTest, AStepIsThereWithin150ms) {
  double sum_ms = 0.0;
  constexpr int kSteps = 20;
  for (int k = 0; k < kSteps; ++k) {
    for (int i = 0; i < 1500; ++i) Step(0.0);
    int delay_ms = 0;
    while (share() < 0.4 && delay_ms < 1000) {
      Step(0.8);
      ++delay_ms;
    }
    EXPECT_LE(delay_ms, 150);
    sum_ms += delay_ms;
  }
  EXPECT_GT(sum_ms / kSteps, 50.0) << "it is smoothed, all the same";
}

TEST_F(EmgTest, EachFaultIsFoundWithinHalfASecondAtRestAndInAGrip) {
  for (const EmgFault fault : {EmgFault::kElectrodeOff, EmgFault::kSaturated, EmgFault::kMainsHum}) {
    for (const double activation : {0.0, 0.3, 1.0}) {
      for (std::size_t channel = 0; channel < kNumChannels; ++channel) {
        for (int i = 0; i < 700 + 37 * static_cast<int>(channel); ++i) Step(activation);  // any phase of the windows
        ASSERT_EQ(estimate_.fault(channel), EmgFault::kNone) << NameOf(fault);
        muscle_.SetFault(channel, fault);
        int found_ms = 0;
        while (estimate_.fault(channel) != fault && found_ms < 2000) {
          Step(activation);
          ++found_ms;
        }
        EXPECT_LE(found_ms, 500) << NameOf(fault) << " at " << activation;
        muscle_.SetFault(channel, EmgFault::kNone);
        for (int i = 0; i < 1000; ++i) Step(activation);
      }
    }
  }
}

TEST_F(EmgTest, NoFaultIsFoundIn10MinutesWithoutOne) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> level(0.0, 1.0);
  double activation = 0.0;
  for (int i = 0; i < 600'000; ++i) {
    if (i % 700 == 0) activation = random() % 3 == 0 ? 0.0 : level(random);
    Step(activation);
    ASSERT_EQ(estimate_.num_faults(), 0) << "after " << i << " ms";
  }
}

TEST_F(EmgTest, AFaultyChannelDoesNotCountAndMoreThanHalfGiveNoForce) {
  for (int i = 0; i < 1000; ++i) Step(0.5);
  for (std::size_t channel = 0; channel < 4; ++channel) muscle_.SetFault(channel, EmgFault::kMainsHum);
  for (int i = 0; i < 1500; ++i) Step(0.5);
  EXPECT_EQ(estimate_.num_faults(), 4);
  EXPECT_NEAR(share(), 0.5, 0.1);
  muscle_.SetFault(4, EmgFault::kElectrodeOff);
  for (int i = 0; i < 1000; ++i) Step(0.5);
  EXPECT_FALSE(estimate_.share());
}

TEST_F(EmgTest, WhatIsNoNumberIsAFaultAndPasses) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 600; ++i) {
    EmgFrame frame = muscle_.Step(0.5);
    frame[2] = i % 3 == 0 ? nan : 1e300;
    estimate_.Step(frame);
  }
  EXPECT_EQ(estimate_.fault(2), EmgFault::kSaturated);
  for (int i = 0; i < 2000; ++i) Step(0.5);
  EXPECT_EQ(estimate_.num_faults(), 0);
  EXPECT_NEAR(share(), 0.5, 0.1);
}

TEST(EmgCalibrator, RefusesAPersonWhoDoesNotGripOrWhoStopsEarly) {
  const auto calibrated = [](double most, int samples) {
    SimulatedMuscle muscle(1);
    ForceEstimate estimate;
    EmgCalibrator calibrator;
    for (const auto& [part, activation] :
         {std::pair{EmgCalibrator::Part::kRest, 0.0}, std::pair{EmgCalibrator::Part::kMost, most}}) {
      for (int i = 0; i < samples; ++i) {
        estimate.Step(muscle.Step(activation));
        calibrator.Add(part, estimate.envelopes_V());
      }
    }
    return calibrator.result().has_value();
  };
  EXPECT_TRUE(calibrated(1.0, 3000));
  EXPECT_FALSE(calibrated(1.0, 2900));
  EXPECT_FALSE(calibrated(0.02, 3000));
}

TEST(GripMap, IsProportionalAndDoesNotChatter) {
  GripMap map(40.0);
  EXPECT_EQ(map.Step(0.09), 0.0);
  EXPECT_NEAR(map.Step(0.5), 20.0, 1e-12);
  EXPECT_NEAR(map.Step(0.06), 2.4, 1e-12);
  EXPECT_EQ(map.Step(0.04), 0.0);
  EXPECT_EQ(map.Step(0.09), 0.0);
  EXPECT_NEAR(map.Step(1.0), 40.0, 1e-12);
  EXPECT_EQ(map.Step(std::nullopt), 0.0);
}

}  // namespace
}  // namespace muscle
